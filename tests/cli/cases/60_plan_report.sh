# plan and report: what is asked for is there, bad requests get one clear line.
demo=$root/data/demo
refuse 2 "where is the tool?" plan --urdf "$demo/arm.urdf"
refuse 2 "needs NAME=X,Y,Z" plan --urdf "$demo/arm.urdf" --place front
refuse 2 "such a placement already" plan --urdf "$demo/arm.urdf" --place a=0.4,0,0.1 --place a=0.4,0.2,0.1
refuse 2 "rows 0: must be a whole number, 1 to 1000" plan --urdf "$demo/arm.urdf" --place a=0.4,0,0.1 --rows 0
refuse 2 "must be a number above 0, at most 180, in degrees" plan --urdf "$demo/arm.urdf" --place a=0.4,0,0.1 --tilt 200
refuse 2 "for needs the DATA" plan --urdf "$demo/arm.urdf" --for 1
refuse 3 "placement far: no pose was found" plan --urdf "$demo/arm.urdf" --place far=3,0,0
"$MUKCA" simulate -q --urdf "$demo/arm.urdf" --seed 5 --noise 1e-4 --perturb 1,2 --effect gear_harmonic:joint_4@100=5e-4 -o sure.tsv
refuse 1 "no two alternatives that postures could separate" plan --urdf "$demo/arm.urdf" sure.tsv --for 1
refuse 1 "there is no such finding" plan --urdf "$demo/arm.urdf" sure.tsv --for 9
answer "^12 postures in 2 sockets; 0 samples recorded" \
    plan --urdf "$demo/arm.urdf" --place front=0.45,0,0.05 --rows 12 -o plan.tsv
expect "a plan tells its unit" grep -q '^# .*joints in rad' plan.tsv
expect "a plan is a session file" "$MUKCA" evaluate -q --urdf "$demo/arm.urdf" plan.tsv -o planned.tsv
# every planned row puts the nominal ball into its socket: 50 mm apart, no spread
expect "its rows sit in the sockets" awk -F '\t' 'NR == 2 && $4 < 1e-6 && $8 < 1e-6 {good = 1} END {exit !good}' planned.tsv
# a finding with alternatives: plan --for proposes the postures of the diagnosis, without a payload for alternatives that are not elastic
agree() { # DATA ARM KIND ROWS: the plan's payload is none or not
    run diagnose -q --urdf "$2" "$1" --json tie.json --force
    run plan -q --urdf "$2" "$1" --for 1 --rows "$4" --json split.json -o split.tsv --force
    expect "plan --for and diagnose agree, $3" python3 -c "
import json, math
d, p = json.load(open('tie.json')), json.load(open('split.json'))
pair = [list(x.values()) for x in d['next_poses'][0]['tells_apart']]
a = {(x['effect'], x['joint']): x['probability'] for x in d['findings'][0]['alternatives']}
assert abs(math.log(a[tuple(pair[0])] / a[tuple(pair[1])]) - p['log_bayes_factor']['before']) < 1e-9
assert len(d['next_poses']) == 10 and len(p['poses']) == $4
assert (p['payload_kg'] > 0) == ('$3' == 'payload'), p['payload_kg']
for x, y in zip(d['next_poses'], p['poses']): # with a payload other postures separate
    assert '$3' == 'payload' or all(abs(a - b) < 1e-9 for a, b in zip(x['q'], y['joints'].values(), strict=True))
    assert '$3' == 'payload' or x['placement'] == y['placement'] and d['joints'] == list(y['joints'])"
}
"$MUKCA" simulate -q --urdf "$demo/arm.urdf" --seed 5 --noise 2e-4 --perturb 1,2 --effect joint_scale:joint_4=3e-3 --rows 20 -o tie.tsv
agree tie.tsv "$demo/arm.urdf" "no payload" 10
panda=$(dirname "$demo")/panda
agree "$panda/train.tsv" "$panda/arm.urdf" payload 4
expect "a plan visits each placement and each socket once, first the placement where the plate is" python3 -c "
import itertools, json
rows = json.load(open('split.json'))['poses']
for keys in ['placement'], ['placement', 'socket']:
    visits = [v for v, _ in itertools.groupby([r[k] for k in keys] for r in rows)]
    assert all(visits.count(v) == 1 for v in visits), visits
last = open('$panda/train.tsv').read().split('\n')[-2].split('\t')[0]
assert rows[0]['placement'] == last or all(r['placement'] != last for r in rows)"
# 66 sockets: a plan has 64, and says so
"$MUKCA" simulate -q --urdf "$demo/arm.urdf" --seed 5 --noise 2e-4 --perturb 1,2 --effect joint_compliance:joint_2=2e-5 \
    --placements 33 --rows 3 -o many.tsv
accept "the plan covers the first 64 sockets; the samples of 2 further ones are not used" \
    plan --urdf "$demo/arm.urdf" many.tsv --rows 2 -o few.tsv
accept "the next postures are for the first 64 sockets; the samples of 2 further ones are not used" diagnose --urdf "$demo/arm.urdf" many.tsv
run plan -q --urdf "$demo/arm.urdf" --place front=0.45,0,0.05 --rows 2 --json -
expect "its JSON has the time taken, and counts as whole numbers" sh -c \
    "grep -q '\"elapsed_s\": [0-9.e-]*' '$scratch/out' && grep -q '\"rows_to_name\": [0-9]*,' '$scratch/out'"
refuse 2 "contains its own frames" report --urdf "$demo/arm.urdf" "$demo/train.tsv" --offsets x.tsv --free-base -o r.html

# a measured distance determines the arm better
expected() { run plan --urdf "$demo/arm.urdf" "$demo/train.tsv" --rows 3 "$@" -o plan.tsv --force --json - &&
    sed -n 's/.*"before": *\([0-9.e-]*\).*/\1/p' "$scratch/out" | head -n 1; }
expect 'a plan uses --distance-sd' awk -v printed="$(expected)" -v measured="$(expected --distance-sd 1e-5)" \
    'BEGIN { exit !(measured > 0 && measured < printed) }'

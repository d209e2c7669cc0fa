/* The columns of the regression: parameters with their priors, the value, effects. */
#include "motion/items.h"

#include <math.h>
#include <string.h>

/* ---- prior deviations of the model's parameters ---- */

/* Of a link as it was built from the CAD data of its URDF: centre of mass (m), inertia. */
#define CENTRE 0.003
#define INERTIA 0.1
/* Of the same where reference runs determine them: any link. */
#define FREE_MASS 1.0
#define FREE_CENTRE 0.1
#define FREE_INERTIA 1.0
#define FREE_ARMATURE 3.0
/* Least squared radius of gyration, m^2: of a link of 10 cm. */
#define GYRATION 0.003
/* Of friction and armature that the model has, relative; with reference runs, of the range. */
#define FRICTION 0.1
#define ARMATURE 0.05
#define FREE_FRICTION 0.3
/* Of the delay of a joint's torque against the others, s: some cycles of a controller. */
#define FREE_DELAY 0.005
/* Of a torque sensor's zero, and of the shape of friction at reversals, relative to the range. */
#define ZERO 0.005
#define REVERSAL 0.25
/* Of friction that is early or late at a reversal: all of it. */
#define LATE 1.0
#define REVERSAL_UNKNOWN 0.03
/* Of delays, those of one joint alone: a bus transports the torques of all joints together. */
#define OWN_DELAY 0.2
/* Odds of friction or armature at a joint for which the model has none: even. */
#define OMITTED (1 / MUKCA_EFFECT_ODDS)
/* An arm's mass without masses in its model, kg: half of that of common ones. */
#define ARM_MASS 20.0

typedef struct {
    mukca_items *out;
    const mukca_motion_input *input;
    const mukca_raw_model *model;
    const mukca_motion_point *point;
    int n; /* joints */
    int most_columns, most_terms, most_items;
    bool reference, masses;
    double total; /* kg */
} lister;

static void end_column(lister *l)
{
    mukca_items *o = l->out;
    if (o->n_columns == l->most_columns) return;
    o->first[++o->n_columns] = o->n_terms;
}

static void put(lister *l, int joint, int raw, double weight)
{
    mukca_items *o = l->out;
    if (weight == 0 || o->n_terms == l->most_terms) return;
    o->term[o->n_terms++] = (mukca_raw_term){(short)joint, (short)raw, weight};
}

static void put_local(lister *l, int joint, int column, double weight)
{
    put(l, joint, mukca_raw_local(l->n, joint, column), weight);
}

/* A parameter of a link acts on all joints before it. */
static void put_link(lister *l, int link, int parameter, double weight)
{
    for (int j = 0; j <= link; j++) put(l, j, mukca_raw_link(j, link, parameter), weight);
}

static const double *inertial_of(const lister *l, int link)
{
    return l->model->inertial + link * MUKCA_INERTIAL;
}

static double mass_of(const lister *l, int link)
{
    const double m = inertial_of(l, link)[0];
    return m > 0 ? m : l->total / l->n;
}

static double gyration_of(const lister *l, int link)
{
    const double *p = inertial_of(l, link);
    return fmax(0.5 * (p[4] + p[5] + p[6]) / mass_of(l, link), GYRATION);
}

/* A column: all parameters of a link in proportion; then one for each coordinate of its centre, and
 * of its inertia if `inertia` is not 0. */
static void put_body(lister *l, int link, double mass, double centre, double inertia)
{
    const double *p = inertial_of(l, link), m = mass_of(l, link);
    if (mass > 0) {
        for (int k = 0; k < MUKCA_INERTIAL; k++) put_link(l, link, k, mass * p[k]);
        if (!(p[0] > 0)) put_link(l, link, 0, mass * m);
        end_column(l);
    }
    for (int a = 0; a < 3 && centre > 0; a++) {
        put_link(l, link, 1 + a, m * centre);
        end_column(l);
    }
    for (int a = 0; a < 6 && inertia > 0; a++) {
        put_link(l, link, 4 + a, m * gyration_of(l, link) * inertia);
        end_column(l);
    }
}

/* The torque of a joint, on which a gain acts. */
static void put_torque(lister *l, int joint, double weight)
{
    for (int r = 0; r < mukca_raw_width(l->n, joint); r++)
        put(l, joint, r, weight * l->point->torque[joint][r]);
}

/* Put the time derivative of a joint's torque; at a delay, the chord from none to it: both are then
 * compared as they are, and not a continuation of one. */
static void put_rate(lister *l, int joint, double weight)
{
    double value[MUKCA_SHIFTS], slope[MUKCA_SHIFTS];
    const double step = l->model->shift * l->model->signals->dt, delay = l->point->delay[joint];
    mukca_raw_interpolate(value, slope, delay / step);
    value[MUKCA_SHIFTS / 2] -= 1;
    for (int k = 0; k < MUKCA_SHIFTS; k++)
        put_local(l, joint, MUKCA_RAW_TORQUE + k,
                  weight * (delay != 0 ? value[k] / delay : slope[k] / step));
}

static void list_local(lister *l, int joint, int column, double sigma)
{
    if (!(sigma > 0)) return;
    put_local(l, joint, column, sigma);
    end_column(l);
}

static void list_parameters(lister *l)
{
    const mukca_drives *d = &l->input->drives;
    for (int k = 0; k < l->n; k++)
        if (l->reference)
            put_body(l, k, FREE_MASS, FREE_CENTRE, FREE_INERTIA);
        else
            put_body(l, k, MUKCA_MASS_ERROR, CENTRE, INERTIA);
    for (int j = 0; j < l->n; j++) {
        const double range = l->model->signals->range[j], free = l->reference ? FREE_FRICTION : 0,
                     speed = fmax(l->model->signals->fastest[j], 1e-3);
        list_local(l, j, MUKCA_RAW_ONE, range * (l->reference ? FREE_FRICTION : ZERO));
        list_local(l, j, MUKCA_RAW_SIGN, fmax(FRICTION * d->coulomb[j], free * range));
        list_local(l, j, MUKCA_RAW_VELOCITY, fmax(FRICTION * d->viscous[j], free * range / speed));
        list_local(l, j, MUKCA_RAW_ACCELERATION,
                   fmax(ARMATURE * d->armature[j],
                        l->reference ? FREE_ARMATURE * l->model->inertia[j] : 0));
        list_local(l, j, MUKCA_RAW_SLOW + MUKCA_SLOWS / 2, 0.3 * free * range);
        list_local(l, j, MUKCA_RAW_SPEED, 0.3 * free * range / speed);
        list_local(l, j, MUKCA_RAW_LOAD, 0.3 * free);
        const double sign = fmax(d->coulomb[j] > 0 ? d->coulomb[j] : REVERSAL_UNKNOWN * range,
                                 l->point->coulomb[j]);
        for (int k = 0; k < MUKCA_REVERSALS; k++)
            list_local(l, j, MUKCA_RAW_REVERSAL + k, (k < 3 ? LATE : REVERSAL) * sign);
    }
    for (int j = 0; j < l->n && l->reference; j++) {
        for (int k = 0; k < l->n; k++) put_rate(l, k, FREE_DELAY * ((k == j) - 1.0 / l->n));
        end_column(l);
    }
    for (int j = 0; j < l->n && l->reference && l->masses; j++, l->out->n_gains++) {
        put_torque(l, j, MUKCA_CURRENT_GAIN);
        end_column(l);
    }
    if (l->input->run[0].current && !l->reference) { /* all gains alike */
        for (int j = 0; j < l->n; j++) put_torque(l, j, MUKCA_CURRENT_GAIN);
        end_column(l);
        l->out->n_gains++;
    }
    l->out->n_parameters = l->out->n_columns;
}

/* ---- the value: measured torque without delay, minus the nominal one ---- */

static void list_value(lister *l, double *scratch)
{
    for (int j = 0; j < l->n; j++) {
        put_local(l, j, MUKCA_RAW_TORQUE + MUKCA_SHIFTS / 2, 1);
        mukca_raw_nominal(scratch, l->model, &l->input->drives, j);
        for (int r = 0; r < mukca_raw_width(l->n, j); r++) put(l, j, r, -scratch[r]);
    }
    end_column(l);
}

/* Columns that share their prior sizes are of the same magnitude. */
static double normal_of(const lister *l, const mukca_torque_effect *e, int joint, int column)
{
    const mukca_signals *s = l->model->signals;
    const int other = column == MUKCA_RAW_BESIDE       ? joint - 1
                      : column == MUKCA_RAW_BESIDE + 4 ? joint + 1
                                                       : -1;
    if (e->n <= 1) return 1;
    if (column == MUKCA_RAW_ONE && e->scale == MUKCA_PER_TRAVEL)
        return 0.5 * (s->high[joint] - s->low[joint]);
    if (other >= 0 && other < l->n) return 1 / fmax(s->fastest[other], 1e-3);
    return 1;
}

static void put_columns(lister *l, const mukca_torque_effect *e, int joint, int variant)
{
    if (e->n == MUKCA_COLUMNS_MODEL) put_torque(l, joint, 1);
    if (e->n == MUKCA_COLUMNS_RATE) put_rate(l, joint, -1);
    for (int c = 0; c < e->n; c++) {
        const int column = e->raw + (e->orders ? variant * e->n + c : variant + c * e->variants);
        put_local(l, joint, column, normal_of(l, e, joint, column));
        end_column(l);
    }
}

static void put_rigid(lister *l, const mukca_torque_effect *e, int link)
{
    if (e->raw == MUKCA_RIGID_CENTRE) put_body(l, link, 0, 1, 0);
    if (e->raw == MUKCA_RIGID_MASS) put_body(l, link, 1, 0, 0); /* as the model distributes it */
    if (e->raw == MUKCA_RIGID_ANY) put_body(l, link, 1, 0.15, 1);
    /* a load is a body of 1 kg within 15 cm, as large as a fist */
    for (int p = 0; p < MUKCA_INERTIAL && e->raw == MUKCA_RIGID_LOAD; p++) {
        put_link(l, link, p, p == 0 ? 1 : p < 4 ? 0.15 : 0.02);
        end_column(l);
    }
}

static double scale_of(const lister *l, const mukca_torque_effect *e, int joint)
{
    const mukca_signals *s = l->model->signals;
    const double range = s->range[joint],
                 by[] = {[MUKCA_PER_RANGE] = range,
                         [MUKCA_PER_SPEED] = range / fmax(s->fastest[joint], 1e-3),
                         [MUKCA_PER_TRAVEL] =
                             range / fmax(0.5 * (s->high[joint] - s->low[joint]), 1e-3),
                         [MUKCA_PER_INERTIA] = l->model->inertia[joint],
                         [MUKCA_PER_MASS] = l->total / 3,
                         [MUKCA_PER_UNIT] = 1};
    return by[e->scale];
}

/* Is it friction or armature that the model omits?  No drive is without. */
static bool is_omitted(const lister *l, int e, int joint)
{
    const double *model = mukca_drives_of(&l->input->drives, e);
    return model && !l->reference && !(model[joint] > 0);
}

/* Begin an item of row e at the joints from .. to; its columns follow. */
static mukca_item *begin(lister *l, int e, int from, int to, int variant)
{
    const mukca_torque_effect *row = &mukca_torque_table[e];
    const mukca_signals *s = l->model->signals;
    mukca_items *o = l->out;
    mukca_item *h = &o->item[o->n_items];
    mukca_label *label = &o->label[o->n_items];
    const double scale = scale_of(l, row, to);
    *h = (mukca_item){.at = o->n_columns - o->n_parameters - 1,
                      .key = ((e * MUKCA_MAX_JOINTS + from) * 2 + (to > from)) * 64 +
                             (row->orders ? variant : 0)};
    for (int k = 0; k < 5 && row->size[k] > 0; k++)
        h->prior.size[h->prior.n_sizes++] = row->size[k] * scale;
    for (int k = 0; k < h->prior.n_sizes; k++) h->prior.log_weight[k] = -log(h->prior.n_sizes);
    h->prior.nonnegative = is_omitted(l, e, to);
    *label = (mukca_label){.family = (int)row->family,
                           .effect = row->name ? e : -1 - e,
                           .from = from,
                           .to = to > from ? from : to,
                           .tie = row->links || row->n == MUKCA_COLUMNS_MODEL,
                           .apart = to > from};
    if (row->orders) {
        label->detail = variant + 1;
        label->blur = (int)fmax(ceil(2 * M_PI / fmax(s->high[to] - s->low[to], 0.05)) - 1, 0);
    }
    o->row[o->n_items] = e;
    o->unit[o->n_items] = e == MUKCA_MOTION_LINK_MASS ? mass_of(l, to) : 1;
    o->n_items++;
    return h;
}

static void finish(lister *l, mukca_item *h, double odds)
{
    h->terms = l->out->n_columns - l->out->n_parameters - 1 - h->at;
    h->log_prior = log(MUKCA_EFFECT_ODDS * odds);
}

/* An order is a wave: longer than the travel it is no wave, shorter than what the filter passes it
 * is gone. */
static bool shows_order(const lister *l, int joint, int order)
{
    const mukca_signals *s = l->model->signals;
    return order * (s->high[joint] - s->low[joint]) > 2 * M_PI &&
           order * s->fastest[joint] < 2 * M_PI * MUKCA_MOTION_CUTOFF;
}

static void list_at(lister *l, int e, int joint)
{
    const mukca_torque_effect *row = &mukca_torque_table[e];
    const double rare = row->n == MUKCA_COLUMNS_RATE ? OWN_DELAY : 1,
                 joints = e == MUKCA_MOTION_PAYLOAD ? 1 : l->n,
                 each = rare * row->odds / joints / row->variants;
    for (int v = 0; v < row->variants; v++) {
        if (row->orders && !shows_order(l, joint, v + 1)) continue;
        mukca_item *h = begin(l, e, joint, joint, v);
        if (row->n == MUKCA_COLUMNS_RIGID)
            put_rigid(l, row, joint);
        else
            put_columns(l, row, joint, v);
        if (row->n < 0) end_column(l);
        finish(l, h, is_omitted(l, e, joint) ? OMITTED : each);
    }
}

/* Gain and delay of all joints alike are one cause: that of the bus, or of a common scale. */
static void list_common(lister *l, int e)
{
    const mukca_torque_effect *row = &mukca_torque_table[e];
    mukca_item *h = begin(l, e, 0, l->n - 1, 0);
    for (int j = 0; j < l->n; j++) put_columns(l, row, j, 0);
    end_column(l);
    finish(l, h, row->odds);
}

/* An unknown function with the columns of an effect is an alternative only where that effect is
 * not: the mass of the last link is a payload. */
static bool is_listed(const lister *l, int e, int joint)
{
    const mukca_torque_effect *row = &mukca_torque_table[e];
    const bool tip = row->links && joint == l->n - 1;
    if (e == MUKCA_MOTION_PAYLOAD && !tip) return false;
    if (e == MUKCA_MOTION_LINK_MASS && tip) return false;
    if (e < MUKCA_MOTION_EFFECTS) return !l->input->disabled[e];
    if (tip) return l->input->disabled[MUKCA_MOTION_PAYLOAD];
    for (int k = 0; k < MUKCA_MOTION_EFFECTS; k++) {
        const mukca_torque_effect *o = &mukca_torque_table[k];
        if (!l->input->disabled[k] && o->family == row->family && o->raw == row->raw &&
            o->n == row->n)
            return false;
    }
    return true;
}

static void list_items(lister *l)
{
    const mukca_signals *s = l->model->signals;
    for (int e = 0; e < MUKCA_TORQUE_ROWS; e++) {
        const mukca_torque_effect *row = &mukca_torque_table[e];
        if (row->n == MUKCA_COLUMNS_MODEL && !l->masses) continue;
        for (int j = 0; j < l->n; j++)
            if (is_listed(l, e, j) && (row->links || s->fastest[j] > MUKCA_LEAST_MOTION))
                list_at(l, e, j);
        if (row->n < 0 && l->n > 1 && is_listed(l, e, 0)) list_common(l, e);
    }
}

bool mukca_items_list(mukca_items *items, mukca_pool *pool, const mukca_motion_input *input,
                      const mukca_raw_model *model, const mukca_motion_point *point)
{
    const int n = model->signals->n_joints;
    lister l = {.out = items, .input = input, .model = model, .point = point, .n = n};
    for (int e = 0; e < MUKCA_TORQUE_ROWS; e++) /* at each joint, and at all */
        l.most_items += n * mukca_torque_table[e].variants + 1;
    l.most_columns = n * 24 + 8 + n * (2 * MUKCA_ORDERS + 230);
    l.most_terms =
        l.most_columns * 4 + n * n * MUKCA_INERTIAL * 40 + 32 * n * mukca_raw_width(n, 0);
    *items = (mukca_items){.first = MUKCA_TAKE(pool, int, l.most_columns + 2),
                           .term = MUKCA_TAKE(pool, mukca_raw_term, l.most_terms),
                           .item = MUKCA_TAKE(pool, mukca_item, l.most_items),
                           .row = MUKCA_TAKE(pool, int, l.most_items),
                           .label = MUKCA_TAKE(pool, mukca_label, l.most_items),
                           .unit = MUKCA_TAKE(pool, double, l.most_items)};
    double *scratch = MUKCA_TAKE(pool, double, mukca_raw_width(n, 0));
    if (pool->failed) return false;
    for (int r = 0; r < input->n_runs; r++)
        l.reference |= input->run[r].role == MUKCA_RUN_REFERENCE;
    for (int k = 0; k < n; k++) l.total += inertial_of(&l, k)[0];
    l.masses = l.total > 0;
    if (!l.masses) l.total = ARM_MASS;
    list_parameters(&l);
    list_value(&l, scratch);
    list_items(&l);
    items->drift = items->n_columns;
    for (int i = 0; i < 2 * n; i++)
        list_local(&l, i / 2, i % 2 ? MUKCA_RAW_SIGN : MUKCA_RAW_WARMING,
                   FREE_FRICTION * model->signals->range[i / 2]);
    return items->n_columns < l.most_columns && items->n_terms < l.most_terms;
}

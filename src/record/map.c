/* The recorder's mapping from the readings of a message to the joints of the arm. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/suggest.h"
#include "base/text.h"
#include "record/recorder.h"

/* Whether --map has the numbers of readings. */
static bool is_numbered(const char *map)
{
    return map && strcmp(map, "name") != 0 && strcmp(map, "order") != 0;
}

/* Numbers as in "8-14" or "1,2,4": 1-based indices of readings. */
mukca_status mukca_stream_check_map(mukca_recorder *r, mukca_error *error)
{
    mukca_stream *stream = &r->stream;
    const char *at = r->options->map;
    if (!is_numbered(at)) return MUKCA_OK;
    int n = 0, joints = r->chain->n_joints;
    while (*at) {
        char *end;
        long first = strtol(at, &end, 10), last = first;
        if (*end == '-') last = strtol(end + 1, &end, 10);
        if (first < 1 || last < first || last > MUKCA_LCM_MAX_JOINTS || (*end && *end != ','))
            return mukca_fail(error, MUKCA_USAGE,
                              "--map %.40s: must be name, order, or numbers as in 8-14 or 1,2,4",
                              r->options->map);
        for (long i = first; i <= last; i++, n++)
            if (n < joints) stream->map.reading[n] = (int)i - 1;
        at = end + (*end == ',');
    }
    if (n != joints)
        return mukca_fail(error, MUKCA_USAGE, "--map names %d readings, but the arm has %d joints",
                          n, joints);
    for (int j = 0; j < joints; j++)
        for (int k = 0; k < j; k++)
            if (stream->map.reading[j] == stream->map.reading[k])
                return mukca_fail(error, MUKCA_USAGE, "--map %.40s: names reading %d twice",
                                  r->options->map, stream->map.reading[j] + 1);
    return MUKCA_OK;
}

bool mukca_stream_find_names(mukca_stream *stream, int *missing, int n_joints)
{
    const mukca_lcm_joints *joints = &stream->last.joints;
    const int n = joints->has[MUKCA_LCM_ROLE_NAME] ? joints->n : 0;
    for (int j = 0; j < n_joints; j++) {
        int k = stream->map.reading[j];
        if (k >= n || strcmp(joints->name[k], stream->map.name[j]) != 0)
            for (k = 0; k < n && strcmp(joints->name[k], stream->map.name[j]) != 0;) k++;
        *missing = j;
        if (k == n) return false;
        stream->map.reading[j] = k;
    }
    return true;
}

/* Map by the sender's names: those of the arm, or with a common prefix. */
static mukca_status map_by_name(mukca_recorder *r)
{
    mukca_stream *stream = &r->stream;
    const mukca_lcm_joints *joints = &stream->last.joints;
    const char *wanted[MUKCA_MAX_JOINTS] = {NULL};
    char name[MUKCA_PREFIX_NAME];
    mukca_prefix prefix;
    const int n = r->chain->n_joints;
    int missing = 0;
    for (int j = 0; j < n; j++) wanted[j] = mukca_chain_joint_name(r->chain, j);
    const int found =
        mukca_prefix_find(&prefix, wanted, n, (const char *const *)joints->name, joints->n);
    for (int j = 0; j < n; j++) {
        mukca_prefix_apply(name, &prefix, wanted[j]);
        snprintf(stream->map.name[j], MUKCA_NAME_SIZE, "%.*s", MUKCA_NAME_SIZE - 1, name);
    }
    if (found > 1)
        return mukca_fail(&stream->problem, MUKCA_INPUT,
                          "channel %s names the joints of several arms, \"%.40s\" among them: give "
                          "the numbers of yours, as in --map 8-14",
                          stream->channel, stream->map.name[0]);
    if (!mukca_stream_find_names(stream, &missing, n))
        return mukca_fail(&stream->problem, MUKCA_INPUT,
                          "channel %s names no joint \"%.40s\" (its first is \"%.40s\"): check "
                          "--urdf, or give the readings' numbers, as in --map 1-%d",
                          stream->channel, stream->map.name[missing], joints->name[0], n);
    stream->map.by_name = true;
    return MUKCA_OK;
}

/* Refuse --map order if a name of the sender is that of another joint of the arm. */
static mukca_status check_names(mukca_recorder *r)
{
    mukca_stream *stream = &r->stream;
    const int n = r->chain->n_joints;
    for (int j = 0; j < n; j++) {
        const char *joint = mukca_chain_joint_name(r->chain, j),
                   *sent = stream->last.joints.name[j];
        for (int k = 0; k < n; k++)
            if (k != j && !mukca_prefix_ends(sent, joint) &&
                mukca_prefix_ends(sent, mukca_chain_joint_name(r->chain, k)))
                return mukca_fail(
                    &stream->problem, MUKCA_INPUT,
                    "--map order contradicts the names: reading %d of %s is \"%.40s\", joint %d of "
                    "the arm is \"%.40s\"; leave out --map, or give numbers, as in --map 3,2,1",
                    j + 1, stream->channel, sent, j + 1, joint);
    }
    return MUKCA_OK;
}

static mukca_status make_map(mukca_recorder *r)
{
    mukca_stream *stream = &r->stream;
    const char *map = r->options->map;
    int joints = r->chain->n_joints, n = stream->last.joints.n;
    bool named = stream->last.joints.has[MUKCA_LCM_ROLE_NAME];
    if (map && strcmp(map, "name") == 0 && !named)
        return mukca_fail(&stream->problem, MUKCA_INPUT,
                          "channel %s sends no joint names: --map order goes by the chain's order",
                          stream->channel);
    if (named && (!map || strcmp(map, "name") == 0)) return map_by_name(r);
    if (is_numbered(map)) {
        for (int j = 0; j < joints; j++)
            if (stream->map.reading[j] >= n)
                return mukca_fail(&stream->problem, MUKCA_INPUT,
                                  "--map names reading %d, but channel %s sends only %d",
                                  stream->map.reading[j] + 1, stream->channel, n);
        return MUKCA_OK;
    }
    if (n != joints)
        return mukca_fail(&stream->problem, MUKCA_INPUT,
                          "channel %s sends %d joints, the arm has %d: %s", stream->channel, n,
                          joints,
                          n > joints ? "choose some with --map, as in --map 8-14"
                                     : "check --urdf, --base and --tip");
    for (int j = 0; j < joints; j++) stream->map.reading[j] = j;
    return named ? check_names(r) : MUKCA_OK;
}

mukca_status mukca_stream_make_map(mukca_recorder *r)
{
    mukca_stream *stream = &r->stream;
    const mukca_status status = make_map(r);
    const bool named = stream->last.joints.has[MUKCA_LCM_ROLE_NAME];
    for (int j = 0; j < r->chain->n_joints && status == MUKCA_OK; j++) {
        char *name = stream->map.name[j];
        snprintf(name, sizeof stream->map.name[j], "%s",
                 named ? stream->last.joints.name[stream->map.reading[j]] : "");
        for (; *name; name++)
            if ((unsigned char)*name < ' ' || *name == 127) *name = '?'; /* for terminals */
    }
    return status;
}

void mukca_stream_describe_map(mukca_text *text, const mukca_recorder *r)
{
    const mukca_stream *stream = &r->stream;
    mukca_text_put(text, "%s (%s), %d readings, mapped by %s:\n", stream->channel,
                   mukca_stream_type(r), stream->map.n, stream->map.by_name ? "name" : "order");
    for (int j = 0; j < r->chain->n_joints; j++)
        mukca_text_put(text, "  reading %2d  %-24s ->  %-24s now %9.4f rad\n",
                       stream->map.reading[j] + 1, stream->map.name[j],
                       mukca_chain_joint_name(r->chain, j), stream->last.reading.q[j]);
}

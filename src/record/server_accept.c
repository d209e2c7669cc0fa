/* Rights and limits of the server's clients. */
#include <string.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "record/server.h"

/* Our choice: a person starts few sessions; a sample takes some 500 bytes. */
static const double first_sessions = 10, sessions_per_s = 0.1, free_bytes = 16e6;

/* Our choice, s: longer than a usual pause between two samples. */
static const double longest_silence = 300;

#define VERB_NAME(name, usage, arguments, sentence) #name,
const char *const mukca_server_verbs[] = {MUKCA_SERVER_VERB_LIST(VERB_NAME) NULL};

/* Whether the comma-separated `list` contains the word text[length]. */
static bool has_word(const char *list, const char *text, size_t length)
{
    for (const char *word = list; word; word = strchr(word, ',')) {
        word += *word == ',';
        if (strcspn(word, ",") == length && strncmp(word, text, length) == 0) return true;
    }
    return false;
}

static const char *accepted(const mukca_server *s)
{
    return s->options->accept ? s->options->accept : MUKCA_SERVER_ACCEPT;
}

bool mukca_server_accepts(const mukca_server *s, const char *right)
{
    if (mukca_lcm_link_replays(s->recorder.link) || has_word(accepted(s), "all", 3)) return true;
    return has_word(accepted(s), right, strlen(right));
}

mukca_status mukca_server_check_accept(const mukca_server *s, mukca_error *error)
{
    for (const char *word = accepted(s); word; word = strchr(word, ',')) {
        word += *word == ',';
        size_t length = strcspn(word, ",");
        bool known = has_word("all,trigger,reopen,status", word, length);
        for (int i = 0; mukca_server_verbs[i] && !known; i++)
            known = has_word(mukca_server_verbs[i], word, length);
        if (!known)
            return mukca_fail(
                error, MUKCA_USAGE,
                "--accept: %.40s is no command; delete, use, reopen and all are possible "
                "besides " MUKCA_SERVER_ACCEPT,
                word);
    }
    return MUKCA_OK;
}

mukca_status mukca_server_control(mukca_server *s, const mukca_lcm_packet *packet,
                                  mukca_error *error)
{
    mukca_server_controller *c = &s->controller;
    const uint32_t address = (uint32_t)(packet->sender >> 16); /* ports differ by client */
    const double silence = 1e-6 * (double)(packet->time - c->heard);
    if (!packet->sender) return MUKCA_OK;
    if (s->recorder.session.file.open && c->heard && c->address != address && silence >= 0 &&
        silence < longest_silence)
        return mukca_fail(
            error, MUKCA_NEGATIVE,
            "session %s is controlled from %u.%u.%u.%u: wait until it is finished, or "
            "for %.0f s without a request from there",
            s->state.session, c->address >> 24, c->address >> 16 & 255, c->address >> 8 & 255,
            c->address & 255, longest_silence);
    *c = (mukca_server_controller){address, packet->time};
    return MUKCA_OK;
}

mukca_status mukca_server_may_start(mukca_server *s, const char *name, mukca_error *error)
{
    char path[MUKCA_SERVER_PATH];
    struct statvfs disk;
    bool current = strcmp(name, s->state.session) == 0 && !s->state.finished[0];
    mukca_server_path(path, s, MUKCA_SERVER_SESSIONS, name, ".tsv");
    if (current || mukca_lcm_link_replays(s->recorder.link)) return MUKCA_OK;
    if (access(path, F_OK) == 0) {
        if (mukca_server_accepts(s, "reopen")) return MUKCA_OK;
        return mukca_fail(error, MUKCA_NEGATIVE,
                          "%s is finished; choose another name, or start serve with --accept "
                          "naming reopen",
                          name);
    }
    if (statvfs(s->options->folder, &disk) == 0 &&
        (double)disk.f_bavail * (double)disk.f_frsize < free_bytes)
        return mukca_fail(error, MUKCA_NEGATIVE, "less than 16 MB are free in %.200s",
                          s->options->folder);
    if (!mukca_budget_take(&s->new_sessions, mukca_lcm_link_clock(s->recorder.link), sessions_per_s,
                           first_sessions, first_sessions))
        return mukca_fail(error, MUKCA_NEGATIVE, "too many new sessions: wait 10 s");
    return MUKCA_OK;
}

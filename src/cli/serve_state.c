/* What `mukca serve` remembers across restarts, and what it tells the service manager. */
#include <ctype.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "cli/serve.h"
#include "io/output.h"

void serve_path(char path[SERVE_PATH], const server *s, const char *name, const char *ending)
{
    snprintf(path, SERVE_PATH, "%.800s/%s%s", s->folder, name, ending);
}

bool serve_name_ok(const char *name)
{
    size_t n = strlen(name);
    if (n < 1 || n > 40 || name[0] == '.' || name[0] == '-') return false;
    for (const char *c = name; *c; c++)
        if (!isalnum((unsigned char)*c) && !strchr("_-.", *c)) return false;
    return true;
}

#define FIELD(name)                                                            \
    {                                                                          \
#name, offsetof(serve_memory, name), sizeof(((serve_memory *)0)->name) \
    }
static const struct {
    const char *key;
    size_t offset, size;
} fields[] = {FIELD(session), FIELD(placement), FIELD(socket),
              FIELD(rows),    FIELD(model),     FIELD(model_stream)};
enum { FIELDS = sizeof fields / sizeof fields[0] };

mukca_status serve_remember(server *s)
{
    char path[SERVE_PATH], line[512];
    memset(&s->memory, 0, sizeof s->memory);
    serve_path(path, s, "state", ".tsv");
    FILE *file = fopen(path, "r");
    while (file && fgets(line, sizeof line, file)) {
        char *value = strchr(line, '\t');
        line[strcspn(line, "\n")] = '\0';
        if (!value) continue;
        *value++ = '\0';
        for (int i = 0; i < FIELDS; i++)
            if (strcmp(line, fields[i].key) == 0)
                snprintf((char *)&s->memory + fields[i].offset, fields[i].size, "%s", value);
    }
    if (file) fclose(file);
    if (s->memory.session[0] && !serve_name_ok(s->memory.session))
        return mukca_fail(&s->call->error, MUKCA_INPUT, "%s is damaged: remove it", path);
    s->saved = s->memory;
    return MUKCA_OK;
}

mukca_status serve_save(server *s, mukca_error *error)
{
    char path[SERVE_PATH];
    mukca_output output;
    if (memcmp(&s->memory, &s->saved, sizeof s->memory) == 0) return MUKCA_OK;
    serve_path(path, s, "state", ".tsv");
    mukca_status status = mukca_output_open(&output, path, true, error);
    if (status) return status;
    for (int i = 0; i < FIELDS; i++)
        fprintf(output.stream, "%s\t%s\n", fields[i].key,
                (const char *)&s->memory + fields[i].offset);
    status = mukca_output_close(&output, error);
    if (!status) s->saved = s->memory;
    return status;
}

/* The protocol of sd_notify(3): one datagram. */
void serve_notify(const char *text)
{
    const char *name = getenv("NOTIFY_SOCKET");
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    if (!name || (name[0] != '/' && name[0] != '@') || strlen(name) >= sizeof address.sun_path)
        return;
    memcpy(address.sun_path, name, strlen(name) + 1);
    if (name[0] == '@') address.sun_path[0] = '\0';
    int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (fd < 0) return;
    socklen_t size = (socklen_t)(offsetof(struct sockaddr_un, sun_path) + strlen(name));
    if (sendto(fd, text, strlen(text), MSG_NOSIGNAL, (const struct sockaddr *)&address, size) < 0) {
        /* no manager listens: nobody to tell */
    }
    close(fd);
}

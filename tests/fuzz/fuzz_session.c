/* Sessions that are resumed: whatever the file holds, it is refused or goes on as it was. */
#include <sys/stat.h>

#include "../unit/arms.h"
#include "io/session_append.h"
#include "memory_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static mukca_chain chain;
    make_chain(&chain, "RR", NULL, "A", 3);
    const mukca_capture_sample sample = {.time = 1, .q = {0.1, 0.2}, .spread = {0.1, 0.2}};
    mukca_session session;
    mukca_error error = {MUKCA_OK, ""};
    struct stat before, after;
    const mukca_session_task task = {.path = memory_file(bytes, size),
                                     .resume = true,
                                     .chain = &chain,
                                     .stream = "raw",
                                     .channel = "C",
                                     .type = "t"};
    if (stat(task.path, &before)) abort();
    mukca_status status = mukca_session_open(&session, &task, &error);
    if (stat(task.path, &after)) abort();
    check_refusal(status, &error);
    if (status && after.st_size != before.st_size) abort();
    if (!status) {
        int rows = session.n_rows;
        if (mukca_session_add(&session, "p", "0", &sample, &error) || session.n_rows != rows + 1)
            abort();
        if (mukca_session_delete(&session, "p", "0", &error) || session.n_rows != rows) abort();
        while (session.n_rows)
            if (mukca_session_delete(&session, "p", "0", &error)) abort();
    }
    mukca_session_close(&session);
    return 0;
}

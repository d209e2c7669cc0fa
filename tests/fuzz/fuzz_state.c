/* What serve keeps across restarts: read or refused; what is read is saved and read again without a
 * change, and names no file outside of its folders. */
#include "memory_folder.h"
#include "record/server.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static mukca_server s;
    mukca_error error = {MUKCA_OK, ""};
    const mukca_server_options options = {.folder = memory_folder()};
    s.options = &options;
    memory_folder_write("state.tsv", bytes, size);
    mukca_status status = mukca_server_load_state(&s, &error);
    check_refusal(status, &error);
    if (status) return 0;
    const mukca_server_state read = s.state;
    if (read.session[0] && !mukca_server_name_ok(read.session)) abort();
    if (strchr(read.model, '/') || strchr(read.candidate, '/')) abort();
    memset(&s.saved, 0xff, sizeof s.saved); /* changed: it is written */
    if (mukca_server_save_state(&s, &error) || mukca_server_load_state(&s, &error)) abort();
    if (memcmp(&s.state, &read, sizeof read) != 0) abort();
    return 0;
}

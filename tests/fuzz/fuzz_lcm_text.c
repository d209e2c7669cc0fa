/* Descriptions of LCM types: all or nothing, and an error that names its place. */
#include "lcm/type.h"
#include "memory_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static mukca_lcm_types types;
    mukca_error error = {MUKCA_OK, ""};
    if (!types.n_types && mukca_lcm_types_init(&types, &error)) abort();
    int n_types = types.n_types, n_fields = types.n_fields;
    char *text = as_text(bytes, size);
    mukca_status status = mukca_lcm_types_parse(&types, text, "fuzz.lcm", &error);
    free(text);
    if (status && (types.n_types != n_types || types.n_fields != n_fields)) abort();
    check_refusal(status, &error);
    if (!status)
        for (int t = n_types; t < types.n_types; t++) {
            mukca_lcm_type_set_role(&types, t, MUKCA_LCM_ROLE_POSITION, "q", &error);
            mukca_lcm_type_set_role(&types, t, MUKCA_LCM_ROLE_POSITION, "head.q", &error);
        }
    types.n_types = n_types;
    types.n_fields = n_fields;
    return 0;
}

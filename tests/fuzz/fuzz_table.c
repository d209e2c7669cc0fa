/* Tables in all three kinds: read to the end or to an error of one line. */
#include "io/table.h"
#include "memory_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    const char *path = memory_file(bytes, size);
    char names[64]; /* the end of the file also as --columns */
    snprintf(names, sizeof names, "%.*s", (int)(size < 60 ? size : 60),
             (const char *)bytes + (size < 60 ? 0 : size - 60));
    for (int kind = MUKCA_HEADER; kind <= MUKCA_EITHER; kind++) {
        mukca_table table;
        mukca_error error = {MUKCA_OK, ""};
        mukca_table_open(&table, path, (mukca_table_kind)kind, &error);
        while (mukca_table_next(&table)) {
            if (kind == MUKCA_EITHER && table.row == 1 && !table.names)
                mukca_columns_rename(&table, names);
            for (int c = 0; c < table.n_columns; c++) mukca_table_number(&table, c);
        }
        check_refusal(mukca_table_close(&table), &error);
    }
    return 0;
}

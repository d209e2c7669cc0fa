/* Command lines: any words for any command are parsed or refused. */
#include "cli/cli.h"
#include "memory_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    char text[512], *words[64];
    int n = 0, commands = 0;
    if (size < 1 || size >= sizeof text) return 0;
    memcpy(text, bytes + 1, size - 1);
    text[size - 1] = '\0';
    for (char *word = strtok(text, "\n"); word && n < 64; word = strtok(NULL, "\n"))
        words[n++] = word;
    while (cli_commands[commands]) commands++;
    if (!commands) return 0;
    cli_call call = {.command = cli_commands[bytes[0] % commands]};
    bool help;
    mukca_status status = cli_parse(&call, &help, n, words);
    check_refusal(status, &call.error);
    cli_call_free(&call);
    return 0;
}

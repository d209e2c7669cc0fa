/* Search for a file of link masses that matches an arm without masses in its URDF. */
#include "io/urdf.h"

#include <dirent.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/note.h"
#include "cli/cli.h"

/* Folders of such files relative to the program: in the source tree, and installed. */
static const char *const folders[] = {"/../data/inertials", "/../../data/inertials",
                                      "/../share/mukca/inertials"};

/* Does a name of the arm contain the name of the file without its ending? */
static bool is_named(const mukca_chain *chain, const char *file)
{
    char stem[MUKCA_NAME_SIZE];
    snprintf(stem, sizeof stem, "%.*s", (int)strcspn(file, "."), file);
    for (int k = 0; k < chain->n_elements; k++)
        if (strstr(chain->element[k].name, stem) || strstr(chain->element[k].child, stem))
            return true;
    return strstr(chain->robot, stem) != NULL;
}

/* Append the files of a folder that match; `named`: only those confirmed by the arm's names. */
static bool list(mukca_text *text, const mukca_chain *chain, const char *folder, bool named)
{
    struct dirent **entries;
    const int n = scandir(folder, &entries, NULL, alphasort);
    for (int i = 0; i < n; i++) {
        const char *name = entries[i]->d_name;
        char path[1400];
        snprintf(path, sizeof path, "%.1100s/%.255s", folder, name);
        if (strstr(name, ".tsv") && (!named || is_named(chain, name)) &&
            mukca_inertials_fit(chain, path))
            mukca_text_put(text, "%s%s", text->used ? " or " : "", path);
        free(entries[i]);
    }
    if (n >= 0) free(entries);
    return text->used > 0;
}

void cli_suggest_inertials(cli_call *call, const mukca_chain *chain)
{
    char program[1024], folder[1100], whole[PATH_MAX], files[2048];
    mukca_text text = MUKCA_TEXT(files);
    if (chain->n_masses > 0) return;
    const ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
    program[length > 0 ? length : 0] = '\0';
    char *slash = strrchr(program, '/');
    if (!slash) return;
    *slash = '\0';
    for (size_t i = 0; i < sizeof folders / sizeof *folders && !text.used; i++) {
        snprintf(folder, sizeof folder, "%s%s", program, folders[i]);
        if (realpath(folder, whole) && !list(&text, chain, whole, true))
            list(&text, chain, whole, false);
    }
    if (text.used)
        mukca_note_format(cli_note, call,
                          "the URDF has no link masses; those of an arm of this geometry: "
                          "--inertials %s",
                          files);
}

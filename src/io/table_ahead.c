/* Rows of a large table read ahead, and their numbers parsed, by a thread of its own. */
#include <math.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdatomic.h>
#include <string.h>
#include <sys/stat.h>

#include "io/table.h"

/* Bytes of a block, and its largest number of cells: a block is ready within milliseconds. */
enum { TEXT = 1 << 19, CELLS = 1 << 15, BLOCKS = 2 };

typedef struct {
    int n, *line;  /* rows, [rows] their lines */
    char *text;    /* [TEXT + MUKCA_TABLE_LINE] */
    char **cell;   /* [rows][n_columns] in the text */
    double *value; /* the same as numbers, SI; NaN: none, or not used */
    bool last;
} block;

typedef struct {
    mukca_table_source source; /* first: the caller's table has its address */
    pthread_t thread;
    sem_t empty, full; /* blocks to be filled, and to be read */
    mukca_table table; /* of the thread; at the end of its last block, that of the whole */
    mukca_error error;
    block block[BLOCKS];
    int rows, now, row; /* rows of a block; the caller's block (-1: none yet), its next row */
    atomic_bool stop;
} read_ahead;

static void fill(block *b, mukca_table *t, int rows)
{
    const size_t n = (size_t)t->n_columns;
    t->buffer = b->text;
    for (b->n = 0; b->n < rows && t->buffer < b->text + TEXT; b->n++) {
        double *value = b->value + (size_t)b->n * n;
        t->cell = b->cell + (size_t)b->n * n;
        b->last = !mukca_table_next(t);
        if (b->last) return;
        b->line[b->n] = t->line;
        for (int c = 0; c < t->n_columns; c++)
            if (!t->used[c] || !mukca_table_parse(&value[c], t, c)) value[c] = (double)NAN;
        t->buffer = t->cell[n - 1] + strlen(t->cell[n - 1]) + 1;
    }
}

/* Wait for a block, also where a signal interrupts. */
static void await(sem_t *blocks)
{
    while (sem_wait(blocks) != 0) continue;
}

static void *run(void *ahead)
{
    read_ahead *a = ahead;
    bool last = false;
    for (int k = 0; !last; k = (k + 1) % BLOCKS) {
        await(&a->empty);
        if (a->stop) break;
        fill(&a->block[k], &a->table, a->rows);
        last = a->block[k].last;
        sem_post(&a->full);
    }
    return NULL;
}

static bool next(mukca_table *t)
{
    read_ahead *a = (read_ahead *)t->source;
    const block *b = a->now < 0 ? NULL : &a->block[a->now];
    if (t->status != MUKCA_OK) return false;
    if (!b || (a->row == b->n && !b->last)) {
        if (b) sem_post(&a->empty);
        a->row = 0;
        a->now = (a->now + 1) % BLOCKS;
        b = &a->block[a->now];
        await(&a->full);
    }
    if (a->row == b->n) { /* the end */
        if (a->table.status != MUKCA_OK) *t->error = a->error;
        t->status = a->table.status;
        t->line = a->table.line;
        t->cut_off = a->table.cut_off;
        return false;
    }
    const size_t at = (size_t)a->row * (size_t)t->n_columns;
    t->cell = b->cell + at;
    t->value = b->value + at;
    t->line = b->line[a->row++];
    t->row++;
    return true;
}

static void close_ahead(mukca_table *t)
{
    read_ahead *a = (read_ahead *)t->source;
    a->stop = true;
    sem_post(&a->empty);
    pthread_join(a->thread, NULL);
    sem_destroy(&a->empty);
    sem_destroy(&a->full);
}

void mukca_table_read_ahead(mukca_table *t)
{
    struct stat file;
    if (t->status != MUKCA_OK || !t->header || fstat(fileno(t->stream), &file) ||
        !S_ISREG(file.st_mode) || file.st_size < BLOCKS * TEXT)
        return;
    read_ahead *a = MUKCA_TAKE(&t->pool, read_ahead, 1);
    if (!a) return;
    a->now = -1;
    a->rows = 1 + CELLS / t->n_columns;
    a->source = (mukca_table_source){next, close_ahead};
    a->table = *t;
    a->table.error = &a->error;
    const int cells = a->rows * t->n_columns;
    for (block *b = a->block; b < a->block + BLOCKS; b++) {
        b->line = MUKCA_TAKE(&t->pool, int, a->rows);
        b->text = MUKCA_TAKE(&t->pool, char, TEXT + MUKCA_TABLE_LINE);
        b->cell = MUKCA_TAKE(&t->pool, char *, cells);
        b->value = MUKCA_TAKE(&t->pool, double, cells);
    }
    if (t->pool.failed || sem_init(&a->empty, 0, BLOCKS) || sem_init(&a->full, 0, 0)) return;
    if (pthread_create(&a->thread, NULL, run, a) == 0) t->source = &a->source;
}

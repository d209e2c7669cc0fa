/* The pool of threads: every block runs once, whatever the number of threads. */
#include "base/workers.h"
#include "close.h"

enum { BLOCKS = 200 };

typedef struct {
    int count, ran[BLOCKS], by[BLOCKS];
} record;

static void mark(void *context, int block, int worker)
{
    record *r = context;
    r->ran[block]++;
    r->by[block] = worker;
}

/* Many loops on one pool, some with fewer blocks than threads. */
TEST(every_block_runs_once)
{
    for (int n = 0; n <= MUKCA_MOST_WORKERS + 1; n += 1 + (n > 3) * 6) {
        mukca_workers *workers = mukca_workers_start(n);
        const int count = mukca_workers_count(workers);
        assert_int_equal(count, n < 2 ? 1 : n < MUKCA_MOST_WORKERS ? n : MUKCA_MOST_WORKERS);
        for (int loop = 0; loop < 200; loop++) {
            const int blocks = loop % 2 ? loop % 5 : BLOCKS;
            record r;
            memset(&r, 0, sizeof r);
            mukca_workers_run(workers, blocks, mark, &r);
            for (int b = 0; b < BLOCKS; b++) {
                assert_int_equal(r.ran[b], b < blocks);
                assert_true(r.by[b] >= 0 && r.by[b] < count);
            }
        }
        mukca_workers_stop(workers);
    }
}

TEST_MAIN(NULL, NULL)

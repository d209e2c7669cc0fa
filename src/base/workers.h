/* Fixed pool of threads for the independent blocks of a loop.
 *
 * The blocks of a loop never depend on the number of threads, and each writes its own results:
 * these are equal for every number. */
#ifndef MUKCA_BASE_WORKERS_H
#define MUKCA_BASE_WORKERS_H

enum { MUKCA_MOST_WORKERS = 16 }; /* each needs scratch memory of its own */

typedef struct mukca_workers mukca_workers;

/* Worker 0 is the caller's thread. */
typedef void mukca_block_fn(void *context, int block, int worker);

/* At most n threads in all, the caller's included; NULL (the caller's alone): n < 2, or none can be
 * started.  All options `threads` are this n. */
mukca_workers *mukca_workers_start(int n);
void mukca_workers_stop(mukca_workers *workers);

/* 1 for NULL. */
int mukca_workers_count(const mukca_workers *workers);

/* Run all blocks; a block must not run others on the same pool. */
void mukca_workers_run(mukca_workers *workers, int blocks, mukca_block_fn *run, void *context);

#endif

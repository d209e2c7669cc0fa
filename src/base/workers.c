/* Fixed pool of threads for the independent blocks of a loop. */
#include "base/workers.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>

/* Looks at a counter before a thread sleeps, some 15 us: the next loop begins, or the last block
 * ends, mostly within that, and to wake a thread takes as long. */
enum { LOOKS = 500 };

struct mukca_workers {
    pthread_mutex_t lock; /* of all members below */
    pthread_cond_t work, done;
    mukca_block_fn *run;
    void *context;
    int blocks, next, open; /* of the loop: all, the first that nobody has taken, unfinished */
    bool stop;
    atomic_int loops, left; /* begun; unfinished blocks: to look at without the lock */
    int n, working;         /* threads, without the caller's; those that have begun */
    pthread_t thread[MUKCA_MOST_WORKERS];
};

/* Take and run blocks until none is left; called and left with the lock. */
static void run_blocks(mukca_workers *w, int worker)
{
    while (w->next < w->blocks) {
        const int block = w->next++;
        pthread_mutex_unlock(&w->lock);
        w->run(w->context, block, worker);
        pthread_mutex_lock(&w->lock);
        atomic_store(&w->left, --w->open);
        if (w->open == 0) pthread_cond_signal(&w->done);
    }
}

/* Without the lock, look for a short time whether a counter changes; called and left with it. */
static void look(mukca_workers *w, atomic_int *counter)
{
    const int value = atomic_load(counter);
    pthread_mutex_unlock(&w->lock);
    for (int k = 0; k < LOOKS && atomic_load(counter) == value; k++) {
#if defined(__x86_64__) && defined(__GNUC__)
        __builtin_ia32_pause();
#endif
    }
    pthread_mutex_lock(&w->lock);
}

static void *work(void *pool)
{
    mukca_workers *w = pool;
    pthread_mutex_lock(&w->lock);
    const int worker = ++w->working;
    while (!w->stop) {
        run_blocks(w, worker);
        look(w, &w->loops);
        if (!w->stop && w->next >= w->blocks) pthread_cond_wait(&w->work, &w->lock);
    }
    pthread_mutex_unlock(&w->lock);
    return NULL;
}

mukca_workers *mukca_workers_start(int n)
{
    mukca_workers *w = n > 1 ? calloc(1, sizeof *w) : NULL;
    if (!w) return NULL;
    if (n > MUKCA_MOST_WORKERS) n = MUKCA_MOST_WORKERS;
    pthread_mutex_init(&w->lock, NULL);
    pthread_cond_init(&w->work, NULL);
    pthread_cond_init(&w->done, NULL);
    while (w->n + 1 < n && pthread_create(&w->thread[w->n], NULL, work, w) == 0) w->n++;
    return w;
}

void mukca_workers_stop(mukca_workers *w)
{
    if (!w) return;
    pthread_mutex_lock(&w->lock);
    w->stop = true;
    pthread_cond_broadcast(&w->work);
    pthread_mutex_unlock(&w->lock);
    for (int k = 0; k < w->n; k++) pthread_join(w->thread[k], NULL);
    pthread_cond_destroy(&w->done);
    pthread_cond_destroy(&w->work);
    pthread_mutex_destroy(&w->lock);
    free(w);
}

int mukca_workers_count(const mukca_workers *w)
{
    return w ? 1 + w->n : 1;
}

void mukca_workers_run(mukca_workers *w, int blocks, mukca_block_fn *run, void *context)
{
    if (!w || blocks < 2) {
        for (int block = 0; block < blocks; block++) run(context, block, 0);
        return;
    }
    pthread_mutex_lock(&w->lock);
    w->run = run, w->context = context;
    w->next = 0, w->blocks = w->open = blocks;
    w->left = blocks;
    w->loops++;
    pthread_cond_broadcast(&w->work);
    run_blocks(w, 0);
    if (w->open) look(w, &w->left);
    while (w->open) pthread_cond_wait(&w->done, &w->lock);
    pthread_mutex_unlock(&w->lock);
}

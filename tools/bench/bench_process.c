/* Run a command REPEATS times without its output: prints the median wall time, s, the largest peak
 * memory, KiB, and the median processor time, s, which other load hardly affects.  A separate small
 * program, because a child's peak includes the memory of its parent at the fork.
 *
 * usage: bench_process REPEATS COMMAND [ARGUMENT...]
 */
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { MAX_REPEATS = 1000 };

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double seconds(struct timeval t)
{
    return (double)t.tv_sec + 1e-6 * (double)t.tv_usec;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

int main(int argc, char **argv)
{
    static double times[MAX_REPEATS], busy[MAX_REPEATS];
    const int repeats = argc > 2 ? atoi(argv[1]) : 0;
    long peak = 0;
    if (repeats < 1 || repeats > MAX_REPEATS) {
        fputs("usage: bench_process REPEATS COMMAND [ARGUMENT...]\n", stderr);
        return 2;
    }
    for (int i = 0; i < repeats; i++) {
        struct rusage usage;
        int status = 0;
        const double start = now();
        const pid_t child = fork();
        if (child == 0) {
            const int null = open("/dev/null", O_WRONLY);
            dup2(null, 1);
            dup2(null, 2);
            execv(argv[2], argv + 2);
            _exit(127);
        }
        if (child < 0 || wait4(child, &status, 0, &usage) != child || status != 0) {
            fprintf(stderr, "bench_process: %s failed (status %d)\n", argv[2], status);
            return 1;
        }
        times[i] = now() - start;
        busy[i] = seconds(usage.ru_utime) + seconds(usage.ru_stime);
        if (usage.ru_maxrss > peak) peak = usage.ru_maxrss;
    }
    qsort(times, (size_t)repeats, sizeof *times, ascending);
    qsort(busy, (size_t)repeats, sizeof *busy, ascending);
    printf("%.6g %ld %.6g\n", times[repeats / 2], peak, busy[repeats / 2]);
    return 0;
}

/* A library to preload that lets one call fail, after SQLite's "out of memory", "I/O error" tests.
 *
 * FAULT=KIND:N fails the N-th call of a kind after the beginning of main, FAULT=KIND:N+ all from
 * the N-th on.  Kinds: malloc, open (of a file to be made), write, fsync, rename (or link),
 * truncate.  FAULT_COUNT=FILE: how many there were of each.  Programs that are started by the
 * program run without faults.
 *
 * FAULT_DISK=FOLDER keeps there what a power cut would leave: for each file that was synced its
 * content then, for each synced folder its entries; writes and renames since then are forgotten.
 *
 * The C library's own writes cannot be replaced by a symbol; a system call filter traps them. */
#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

enum { MALLOC, OPEN, WRITE, FSYNC, RENAME, TRUNCATE, KINDS };
static const char *const kinds[KINDS] = {"malloc", "open", "write", "fsync", "rename", "truncate"};
static const int reasons[KINDS] = {ENOMEM, ENOSPC, ENOSPC, EIO, EIO, EIO};
static long count[KINDS], at;
static int kind = -1;
static bool lasting, counting;
static const char *count_file, *disk;
static const unsigned magic = 0x6d756b63; /* a sixth argument that marks our own writes */

static bool fails(int which)
{
    if (!counting) return false;
    const long n = __atomic_add_fetch(&count[which], 1, __ATOMIC_RELAXED);
    if (which != kind || n < at || (n > at && !lasting)) return false;
    errno = reasons[which];
    return true;
}

/* ---- memory ---- */

extern void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t);

void *malloc(size_t size)
{
    return fails(MALLOC) ? NULL : __libc_malloc(size);
}

void *calloc(size_t n, size_t size)
{
    return fails(MALLOC) ? NULL : __libc_calloc(n, size);
}

void *realloc(void *old, size_t size)
{
    return fails(MALLOC) ? NULL : __libc_realloc(old, size);
}

/* ---- the disk after a power cut ---- */

static long real_write(int fd, const void *data, size_t size)
{
    return syscall(SYS_write, fd, data, size, 0, 0, magic);
}

/* A whole file or none: `lines`, or a copy of `from`. */
static void put(const char *kind_of, unsigned long inode, int from, const char *lines)
{
    char path[4096], temporary[4200], buffer[65536];
    long n;
    snprintf(path, sizeof path, "%s/%s-%lu", disk, kind_of, inode);
    snprintf(temporary, sizeof temporary, "%s.%d", path, getpid());
    int to = (int)syscall(SYS_openat, AT_FDCWD, temporary, O_WRONLY | O_CREAT | O_TRUNC, 0666);
    off_t offset = 0;
    if (lines) real_write(to, lines, strlen(lines));
    while (!lines && (n = pread(from, buffer, sizeof buffer, offset)) > 0 &&
           real_write(to, buffer, (size_t)n) == n)
        offset += n;
    close(to);
    syscall(SYS_renameat, AT_FDCWD, temporary, AT_FDCWD, path);
}

/* An inode must not be used again while the disk names it. */
static void hold(int fd, unsigned long inode)
{
    char from[64], to[4096];
    snprintf(from, sizeof from, "/proc/self/fd/%d", fd);
    snprintf(to, sizeof to, "%s/held-%lu", disk, inode);
    (void)!syscall(SYS_linkat, AT_FDCWD, from, AT_FDCWD, to, AT_SYMLINK_FOLLOW);
}

static void remember_folder(int fd, unsigned long inode)
{
    char own[64], lines[1 << 16] = "";
    size_t length = 0;
    snprintf(own, sizeof own, "/proc/self/fd/%d", fd);
    counting = false; /* opendir allocates */
    DIR *entries = opendir(own);
    for (struct dirent *e; entries && (e = readdir(entries)) && length + 300 < sizeof lines;)
        if (e->d_name[0] != '.' || strlen(e->d_name) > 2)
            length += (size_t)sprintf(lines + length, "%lu %c %s\n", (unsigned long)e->d_ino,
                                      e->d_type == DT_DIR ? 'd' : 'f', e->d_name);
    if (entries) closedir(entries);
    counting = true;
    put("folder", inode, -1, lines);
}

static void remember(int fd)
{
    struct stat info;
    char own[64];
    if (!disk || fstat(fd, &info)) return;
    const unsigned long inode = (unsigned long)info.st_ino;
    if (S_ISDIR(info.st_mode)) {
        remember_folder(fd, inode);
        return;
    }
    snprintf(own, sizeof own, "/proc/self/fd/%d", fd); /* which may be open for writing only */
    int from = (int)syscall(SYS_openat, AT_FDCWD, own, O_RDONLY, 0);
    put("file", inode, from, NULL);
    close(from);
}

/* ---- files ---- */

int open(const char *path, int flags, ...)
{
    va_list more;
    va_start(more, flags);
    const int mode = flags & O_CREAT ? va_arg(more, int) : 0;
    va_end(more);
    if (flags & O_CREAT && fails(OPEN)) return -1;
    const int fd = (int)syscall(SYS_openat, AT_FDCWD, path, flags, mode);
    struct stat info;
    if (disk && fd >= 0 && flags & O_CREAT && fstat(fd, &info) == 0 && S_ISREG(info.st_mode))
        hold(fd, (unsigned long)info.st_ino);
    return fd;
}

int fsync(int fd)
{
    if (fails(FSYNC)) return -1;
    remember(fd);
    return disk ? 0 : (int)syscall(SYS_fsync, fd);
}

int rename(const char *from, const char *to)
{
    return fails(RENAME) ? -1 : (int)syscall(SYS_renameat, AT_FDCWD, from, AT_FDCWD, to);
}

int link(const char *from, const char *to)
{
    return fails(RENAME) ? -1 : (int)syscall(SYS_linkat, AT_FDCWD, from, AT_FDCWD, to, 0);
}

int ftruncate(int fd, off_t length)
{
    return fails(TRUNCATE) ? -1 : (int)syscall(SYS_ftruncate, fd, length);
}

ssize_t pwrite(int fd, const void *data, size_t size, off_t offset)
{
    return fails(WRITE) ? -1 : syscall(SYS_pwrite64, fd, data, size, offset);
}

/* ---- writes of the C library ---- */

static void on_write(int number, siginfo_t *info, void *context)
{
    const int before = errno;
    greg_t *r = ((ucontext_t *)context)->uc_mcontext.gregs;
    (void)number, (void)info;
    const int fd = (int)r[REG_RDI];
    long result = -1;
    if (fd == STDERR_FILENO || !fails(WRITE))
        result = real_write(fd, (const void *)r[REG_RSI], (size_t)r[REG_RDX]);
    r[REG_RAX] = result < 0 ? -errno : result;
    errno = before;
}

static void trap_writes(void)
{
    struct sigaction action = {.sa_sigaction = on_write, .sa_flags = SA_SIGINFO | SA_NODEFER};
    struct sock_filter code[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, nr)),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_write, 0, 3),
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, args[5])),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, magic, 1, 0),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
    };
    const struct sock_fprog filter = {sizeof code / sizeof code[0], code};
    sigaction(SIGSYS, &action, NULL);
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) ||
        prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter))
        _exit(77);
}

/* ---- begin and end ---- */

static int (*real_main)(int, char **, char **);

static int counted_main(int argc, char **argv, char **environment)
{
    counting = true;
    const int code = real_main(argc, argv, environment);
    counting = false;
    if (count_file) {
        int fd = open(count_file, O_WRONLY | O_CREAT | O_TRUNC, 0666);
        for (int k = 0; k < KINDS; k++) dprintf(fd, "%s %ld\n", kinds[k], count[k]);
        close(fd);
    }
    return code;
}

int __libc_start_main(int (*main)(int, char **, char **), int argc, char **argv, void (*init)(void),
                      void (*end)(void), void (*unload)(void), void *stack)
{
    int (*real)(int (*)(int, char **, char **), int, char **, void (*)(void), void (*)(void),
                void (*)(void), void *);
    *(void **)&real = dlsym(RTLD_NEXT, "__libc_start_main");
    const char *fault = getenv("FAULT");
    for (int k = 0; k < KINDS && fault; k++) {
        const size_t n = strlen(kinds[k]);
        if (strncmp(fault, kinds[k], n) != 0 || fault[n] != ':') continue;
        char *rest;
        kind = k;
        at = strtol(fault + n + 1, &rest, 10);
        lasting = *rest == '+';
    }
    count_file = getenv("FAULT_COUNT");
    disk = getenv("FAULT_DISK");
    /* programs started later inherit the filter of system calls, and need its handler */
    if (kind == WRITE || count_file || getenv("FAULT_TRAP")) {
        trap_writes();
        setenv("FAULT_TRAP", "1", 1);
    }
    unsetenv("FAULT");
    unsetenv("FAULT_COUNT");
    real_main = main;
    return real(fault || count_file || disk ? counted_main : main, argc, argv, init, end, unload,
                stack);
}

/* Faults of a disk, for one process: preloaded (LD_PRELOAD) between SQLite and the system's calls on files.

   A shared file of five 32-bit integers says what happens: which calls fail (a mask), how, after how many calls, for how
   many calls; and it counts the faults that happened. Only files whose path begins with DISK_FAULTS_FILES are concerned.
   libfiu was tried first: the service hangs at its start under it. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/types.h>
#include <unistd.h>

enum { WRITE = 1, SYNC = 2, READ = 4, TRUNCATE = 8 };
enum { FAIL_EIO = 0, FAIL_ENOSPC = 1, SHORT = 2, TORN_AND_KILLED = 3, FLIPPED = 4, LOST = 5 };

struct control {
    atomic_int mask, how, skip, times, happened;
};

static struct control none, *control = &none;
static const char *files;

__attribute__((constructor)) static void start(void) {
    const char *path = getenv("DISK_FAULTS_CONTROL");
    files = getenv("DISK_FAULTS_FILES");
    int file = path && files ? open(path, O_RDWR | O_CLOEXEC) : -1;
    if (file < 0) return;
    void *shared = mmap(NULL, sizeof none, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    if (shared != MAP_FAILED) control = shared;
    close(file);
}

/* Returns what happens to this call; -1: nothing. */
static int fault(int call, int file) {
    char link[64], path[4096];
    if (!(atomic_load(&control->mask) & call)) return -1;
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (length < 0) return -1;
    path[length] = 0;
    if (strncmp(path, files, strlen(files))) return -1;
    if (atomic_fetch_sub(&control->skip, 1) > 0) return -1;
    if (atomic_fetch_sub(&control->times, 1) <= 0) {
        atomic_fetch_add(&control->times, 1);
        return -1;
    }
    atomic_fetch_add(&control->happened, 1);
    return atomic_load(&control->how);
}

static int failure(int how) {
    errno = how == FAIL_ENOSPC ? ENOSPC : EIO;
    return -1;
}

#define REAL(name, type, ...) \
    static type (*real)(__VA_ARGS__); \
    if (!real) real = (type (*)(__VA_ARGS__))dlsym(RTLD_NEXT, name)

ssize_t pwrite64(int file, const void *data, size_t size, off64_t at) {
    REAL("pwrite64", ssize_t, int, const void *, size_t, off64_t);
    int how = fault(WRITE, file);
    if (how < 0) return real(file, data, size, at);
    if (how == SHORT) return real(file, data, size / 2, at);
    if (how == LOST) return (ssize_t)size;
    if (how == TORN_AND_KILLED) {
        real(file, data, size / 2, at);
        kill(getpid(), SIGKILL);
        pause();
    }
    if (how == FLIPPED) {
        char *copy = malloc(size);
        memcpy(copy, data, size);
        copy[size / 3] ^= 16;
        ssize_t written = real(file, copy, size, at);
        free(copy);
        return written;
    }
    return failure(how);
}

ssize_t pread64(int file, void *data, size_t size, off64_t at) {
    REAL("pread64", ssize_t, int, void *, size_t, off64_t);
    int how = fault(READ, file);
    if (how < 0) return real(file, data, size, at);
    if (how == FLIPPED) {
        ssize_t got = real(file, data, size, at);
        if (got > 0) ((char *)data)[got / 3] ^= 16;
        return got;
    }
    return failure(how);
}

int fsync(int file) {
    REAL("fsync", int, int);
    int how = fault(SYNC, file);
    return how < 0 ? real(file) : failure(how);
}

int fdatasync(int file) {
    REAL("fdatasync", int, int);
    int how = fault(SYNC, file);
    return how < 0 ? real(file) : failure(how);
}

int ftruncate64(int file, off64_t size) {
    REAL("ftruncate64", int, int, off64_t);
    int how = fault(TRUNCATE, file);
    return how < 0 ? real(file, size) : failure(how);
}

/* Failures of the file system, for the processes that are started with this object in LD_PRELOAD.
 *
 * Each operation on a path below `root` is counted by its kind; the one whose turn it is fails, and with `sticky` all
 * that follow it. What the variables below hold is set through ctypes by tests/robustness/faults.py.
 */
#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

enum { NONE, OPEN, WRITE, FSYNC, CLOSE, RENAME, UNLINK, MKDIR, RMDIR, CHMOD, OPENDIR };
enum { TORN = 1, SHORT = 2, DIES = 3 };

char faults_root[PATH_MAX];   /* with no slash at its end; empty: nothing fails */
int faults_kind = NONE;       /* what fails */
int faults_turn = -1;         /* the how manieth of these, from 0 */
int faults_errno = 0;         /* how it fails */
int faults_manner = 0;        /* of a write: half of it is done first, and then it fails, returns, or the process ends */
int faults_sticky = 0;        /* whether all that follow fail too */
int faults_seen = 0;          /* so many of this kind were counted */
int faults_fired = 0;         /* so many failed */
int faults_locks = 0;         /* errno of every lock; -1: every lock is granted and none is held */

static int below(const char *path) {
    size_t length = strlen(faults_root);
    return length && path && strncmp(path, faults_root, length) == 0 && (path[length] == '/' || !path[length]);
}

static int fd_below(int fd) {
    char link[64], path[PATH_MAX];
    if (!*faults_root) return 0;
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t n = readlink(link, path, sizeof path - 1);
    if (n < 0) return 0;
    path[n] = 0;
    return below(path);
}

static int fails(int kind) {
    if (kind != faults_kind) return 0;
    int turn = faults_seen++;
    if (turn != faults_turn && !(faults_sticky && turn > faults_turn)) return 0;
    faults_fired++;
    errno = faults_errno;
    return 1;
}

#define REAL(type, name, ...) \
    static type (*real)(__VA_ARGS__); \
    if (!real) real = dlsym(RTLD_NEXT, #name)

#define OPENS(name) \
    int name(const char *path, int flags, ...) { \
        REAL(int, name, const char *, int, ...); \
        va_list more; va_start(more, flags); int mode = va_arg(more, int); va_end(more); \
        if (below(path) && (flags & (O_WRONLY | O_RDWR | O_CREAT)) && fails(OPEN)) return -1; \
        return real(path, flags, mode); \
    }
OPENS(open)
OPENS(open64)

#define OPENS_AT(name) \
    int name(int folder, const char *path, int flags, ...) { \
        REAL(int, name, int, const char *, int, ...); \
        va_list more; va_start(more, flags); int mode = va_arg(more, int); va_end(more); \
        if (below(path) && (flags & (O_WRONLY | O_RDWR | O_CREAT)) && fails(OPEN)) return -1; \
        return real(folder, path, flags, mode); \
    }
OPENS_AT(openat)
OPENS_AT(openat64)

ssize_t write(int fd, const void *content, size_t size) {
    REAL(ssize_t, write, int, const void *, size_t);
    if (faults_kind == WRITE && fd_below(fd) && fails(WRITE)) {
        if (!faults_manner || faults_fired > 1) return -1;
        ssize_t half = real(fd, content, size / 2);
        if (faults_manner == DIES) _exit(137);
        if (faults_manner == SHORT && half > 0) return half;
        errno = faults_errno;
        return -1;
    }
    return real(fd, content, size);
}

#define ON_FD(kind, name) \
    int name(int fd) { \
        REAL(int, name, int); \
        if (faults_kind == kind && fd_below(fd) && fails(kind)) { \
            if (kind == CLOSE) real(fd); \
            errno = faults_errno; \
            return -1; \
        } \
        return real(fd); \
    }
ON_FD(FSYNC, fsync)
ON_FD(FSYNC, fdatasync)
ON_FD(CLOSE, close)

#define ON_PATH(kind, name) \
    int name(const char *path) { \
        REAL(int, name, const char *); \
        return below(path) && fails(kind) ? -1 : real(path); \
    }
ON_PATH(UNLINK, unlink)
ON_PATH(RMDIR, rmdir)

#define WITH_MODE(kind, name) \
    int name(const char *path, mode_t mode) { \
        REAL(int, name, const char *, mode_t); \
        return below(path) && fails(kind) ? -1 : real(path, mode); \
    }
WITH_MODE(MKDIR, mkdir)
WITH_MODE(CHMOD, chmod)

int rename(const char *from, const char *to) {
    REAL(int, rename, const char *, const char *);
    return below(to) && fails(RENAME) ? -1 : real(from, to);
}

DIR *opendir(const char *path) {
    REAL(DIR *, opendir, const char *);
    return below(path) && fails(OPENDIR) ? NULL : real(path);
}

int flock(int fd, int operation) {
    REAL(int, flock, int, int);
    if (!faults_locks || !fd_below(fd)) return real(fd, operation);
    if (faults_locks == -1) return 0;
    errno = faults_locks;
    return -1;
}

#define CONTROLS(name) \
    int name(int fd, int command, ...) { \
        REAL(int, name, int, int, ...); \
        va_list more; va_start(more, command); void *value = va_arg(more, void *); va_end(more); \
        int locks = command == F_SETLK || command == F_SETLKW; \
        if (!locks || !faults_locks || !fd_below(fd)) return real(fd, command, value); \
        if (faults_locks == -1) return 0; \
        errno = faults_locks; \
        return -1; \
    }
CONTROLS(fcntl)
CONTROLS(fcntl64)

/* Faults of a disk, for a program that is started with this library preloaded. FAULT_FOLDER says where: only files in
 * that folder, or folders in it, are touched. The rest of the environment says what:
 *
 *   FAULT_COUNT=FILE        nothing, but the number of calls that change something is written there at the end
 *   FAULT_KILL=N            the N-th of these calls kills the program; a write writes half of it first
 *   FAULT_FULL=BYTES        the disk has room for so many bytes
 *   FAULT_READ_ONLY         nothing can be made or changed
 *   FAULT_NAMED             files have names
 *   FAULT_NO_RENAME=NAME    nothing can take this name
 *   FAULT_NO_FOLDER_SYNC    folders cannot be synced (EINVAL)
 *   FAULT_MOVE=FOLDER       the folder is moved there when the first file of it is synced
 *
 * The calls are those that Rust's standard library makes. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

static long count = 0, written = 0;

static void *real(const char *name) { return dlsym(RTLD_NEXT, name); }

static int here(const char *path) {
    const char *folder = getenv("FAULT_FOLDER");
    char whole[4096];
    if (!folder || !path) return 0;
    if (path[0] == '/') {
        snprintf(whole, sizeof whole, "%s", path);
    } else {
        char place[2048];
        if (!getcwd(place, sizeof place)) return 0;
        snprintf(whole, sizeof whole, "%s/%s", place, path);
    }
    return strncmp(whole, folder, strlen(folder)) == 0;
}

static int file_here(int fd) {
    char link[64], path[4096];
    struct stat found;
    if (fstat(fd, &found) || !S_ISREG(found.st_mode)) return 0;
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (length < 0) return 0;
    path[length] = 0;
    return here(path);
}

static void end(void) { kill(getpid(), SIGKILL), pause(); }

/* Whether this call is the last. */
static int is_last(void) {
    const char *last = getenv("FAULT_KILL");
    count++;
    return last && count == atol(last);
}

static int is_read_only(void) {
    if (!getenv("FAULT_READ_ONLY")) return 0;
    errno = EROFS;
    return 1;
}

__attribute__((destructor)) static void tell(void) {
    const char *file = getenv("FAULT_COUNT");
    if (!file) return;
    FILE *to = fopen(file, "w");
    if (to) fprintf(to, "%ld", count), fclose(to);
}

static int open_any(const char *name, const char *path, int flags, int mode) {
    int (*open_real)(const char *, int, ...) = real(name);
    int nameless = (flags & O_TMPFILE) == O_TMPFILE;
    if (here(path) && (nameless || (flags & (O_CREAT | O_TRUNC)))) {
        if (nameless && getenv("FAULT_NAMED")) {
            errno = EOPNOTSUPP;
            return -1;
        }
        if (is_read_only()) return -1;
        if (is_last()) end();
    }
    return open_real(path, flags, mode);
}

#define OPEN(name)                                            \
    int name(const char *path, int flags, ...) {              \
        va_list more;                                         \
        va_start(more, flags);                                \
        int mode = va_arg(more, int);                         \
        va_end(more);                                         \
        return open_any(#name, path, flags, mode);            \
    }
OPEN(open)
OPEN(open64)

ssize_t write(int fd, const void *bytes, size_t size) {
    ssize_t (*write_real)(int, const void *, size_t) = real("write");
    if (file_here(fd)) {
        const char *full = getenv("FAULT_FULL");
        if (full && written + (long)size > atol(full)) {
            long room = atol(full) - written;
            if (room <= 0) {
                errno = ENOSPC;
                return -1;
            }
            size = room;
        }
        if (is_last()) write_real(fd, bytes, size / 2), end();
        written += size;
    }
    return write_real(fd, bytes, size);
}

ssize_t writev(int fd, const struct iovec *parts, int number) {
    ssize_t (*writev_real)(int, const struct iovec *, int) = real("writev");
    if (file_here(fd) && number > 0) return write(fd, parts[0].iov_base, parts[0].iov_len);
    return writev_real(fd, parts, number);
}

/* Copies go by `write`, which counts. */
ssize_t copy_file_range(int a, off64_t *b, int c, off64_t *d, size_t e, unsigned f) {
    (void)a, (void)b, (void)c, (void)d, (void)e, (void)f;
    errno = ENOSYS;
    return -1;
}
ssize_t sendfile64(int a, int b, off64_t *c, size_t d) {
    (void)a, (void)b, (void)c, (void)d;
    errno = ENOSYS;
    return -1;
}
ssize_t sendfile(int a, int b, off_t *c, size_t d) { return sendfile64(a, b, c, d); }

int fsync(int fd) {
    static int moved = 0;
    int (*fsync_real)(int) = real("fsync");
    struct stat found;
    if (getenv("FAULT_NO_FOLDER_SYNC") && !fstat(fd, &found) && S_ISDIR(found.st_mode)) {
        errno = EINVAL;
        return -1;
    }
    if (!file_here(fd)) return fsync_real(fd);
    if (is_last()) end();
    const char *to = getenv("FAULT_MOVE");
    if (to && !moved++) {
        int (*rename_real)(const char *, const char *) = real("rename");
        rename_real(getenv("FAULT_FOLDER"), to);
    }
    return fsync_real(fd);
}

int rename(const char *from, const char *to) {
    int (*rename_real)(const char *, const char *) = real("rename");
    if (here(from) || here(to)) {
        const char *refused = getenv("FAULT_NO_RENAME");
        const char *name = strrchr(to, '/');
        if (refused && strcmp(name ? name + 1 : to, refused) == 0) {
            errno = EPERM;
            return -1;
        }
        if (is_read_only()) return -1;
        if (is_last()) end();
        int done = rename_real(from, to);
        if (is_last()) end();
        return done;
    }
    return rename_real(from, to);
}

int unlink(const char *path) {
    int (*unlink_real)(const char *) = real("unlink");
    if (here(path)) {
        if (is_read_only()) return -1;
        if (is_last()) end();
    }
    return unlink_real(path);
}

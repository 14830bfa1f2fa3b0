/* Stands between the program and the system: counts what is written below some folders (and on
 * standard output), and fails one of these operations. Loaded by LD_PRELOAD.
 *
 * SHIM_UNDER   folders, with colons between
 * SHIM_STDOUT  whether writes to descriptor 1 count, and nothing else does
 * SHIM_AT      which operation fails, from 1; 0: none
 * SHIM_HOW     enospc, eio, epipe, or short: half is written, then there is no space
 * SHIM_NOSYNC  whether no file and no folder can be synced, as on some shares of a network
 * SHIM_LOG     a file that gets a line for each operation
 * SHIM_DATA    whether the log also has what was written, in hexadecimal
 */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <pthread.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

static const char *under = "";
static int only_stdout, with_data, no_sync, how, full, logfd = -1;
static long at, count;
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

enum { NONE, FAIL, SHORT };

__attribute__((constructor)) static void begin(void) {
  const char *text;
  if ((text = getenv("SHIM_UNDER"))) under = text;
  only_stdout = getenv("SHIM_STDOUT") != NULL;
  with_data = getenv("SHIM_DATA") != NULL;
  no_sync = getenv("SHIM_NOSYNC") != NULL;
  if ((text = getenv("SHIM_AT"))) at = atol(text);
  text = getenv("SHIM_HOW");
  how = !text ? 0
        : !strcmp(text, "enospc") ? ENOSPC
        : !strcmp(text, "eio")    ? EIO
        : !strcmp(text, "epipe")  ? EPIPE
                                  : -1;
  if ((text = getenv("SHIM_LOG")))
    logfd = syscall(SYS_openat, AT_FDCWD, text, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
}

static void whole(char *out, const char *path) {
  if (path[0] == '/') {
    snprintf(out, PATH_MAX, "%s", path);
    return;
  }
  char cwd[PATH_MAX];
  if (syscall(SYS_getcwd, cwd, sizeof cwd) < 0) cwd[0] = 0;
  snprintf(out, PATH_MAX, "%s/%s", cwd, path);
}

static int of_descriptor(char *out, int fd) {
  char link[64];
  snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  long n = syscall(SYS_readlinkat, AT_FDCWD, link, out, PATH_MAX - 1);
  if (n < 0) return 0;
  out[n] = 0;
  return 1;
}

static int inside(const char *path) {
  const char *from = under;
  while (*from) {
    const char *end = strchrnul(from, ':');
    size_t n = end - from;
    if (n && !strncmp(path, from, n) && (path[n] == '/' || !path[n])) return 1;
    from = *end ? end + 1 : end;
  }
  return 0;
}

static void line(const char *text) {
  if (logfd >= 0) syscall(SYS_write, logfd, text, strlen(text));
}

/* One more operation: whether and how it fails. */
static int operation(const char *name, const char *path) {
  char text[2 * PATH_MAX];
  pthread_mutex_lock(&lock);
  long number = ++count;
  int fails = NONE;
  if (at == number) fails = how == -1 ? SHORT : FAIL;
  if (full && !strcmp(name, "write")) fails = FAIL;
  if (!with_data) {
    snprintf(text, sizeof text, "%ld\t%s\t%s%s\n", number, name, path, fails ? "\tfails" : "");
    line(text);
  }
  if (fails == SHORT && strcmp(name, "write")) fails = FAIL;
  if (fails == FAIL) errno = how == -1 ? ENOSPC : how;
  pthread_mutex_unlock(&lock);
  return fails;
}

/* What was done, for whoever does it again. */
static void done(const char *format, ...) {
  if (!with_data || logfd < 0) return;
  char text[3 * PATH_MAX];
  va_list list;
  va_start(list, format);
  vsnprintf(text, sizeof text, format, list);
  va_end(list);
  int before = errno;
  line(text);
  errno = before;
}

static void data(int fd, const char *path, const void *bytes, size_t n, off_t to) {
  if (!with_data || logfd < 0) return;
  (void)fd;
  int before = errno;
  size_t size = strlen(path) + 64 + 2 * n;
  char *text = malloc(size);
  int begun = snprintf(text, size, "write\t%s\t%ld\t", path, (long)to);
  for (size_t i = 0; i < n; i++)
    sprintf(text + begun + 2 * i, "%02x", ((const unsigned char *)bytes)[i]);
  strcat(text, "\n");
  line(text);
  free(text);
  errno = before;
}

static off_t place(int fd) {
  struct stat now;
  int flags = syscall(SYS_fcntl, fd, F_GETFL);
  if (flags >= 0 && flags & O_APPEND && !fstat(fd, &now)) return now.st_size;
  return syscall(SYS_lseek, fd, 0, SEEK_CUR);
}

static int counted(char *path, int fd) {
  if (only_stdout) {
    strcpy(path, "stdout");
    return fd == 1;
  }
  return of_descriptor(path, fd) && inside(path);
}

ssize_t write(int fd, const void *bytes, size_t n) {
  char path[PATH_MAX];
  if (!counted(path, fd)) return syscall(SYS_write, fd, bytes, n);
  switch (operation("write", path)) {
    case FAIL:
      return -1;
    case SHORT:
      full = 1;
      if (n > 1) return syscall(SYS_write, fd, bytes, n / 2);
      errno = ENOSPC;
      return -1;
  }
  off_t to = place(fd);
  ssize_t wrote = syscall(SYS_write, fd, bytes, n);
  if (wrote > 0) data(fd, path, bytes, wrote, to);
  return wrote;
}

ssize_t writev(int fd, const struct iovec *parts, int n) {
  char path[PATH_MAX];
  if (!counted(path, fd)) return syscall(SYS_writev, fd, parts, n);
  /* Part by part: a short write is allowed. */
  for (int i = 0; i < n; i++)
    if (parts[i].iov_len) return write(fd, parts[i].iov_base, parts[i].iov_len);
  return 0;
}

ssize_t pwrite64(int fd, const void *bytes, size_t n, off64_t to) {
  char path[PATH_MAX];
  if (!counted(path, fd)) return syscall(SYS_pwrite64, fd, bytes, n, to);
  switch (operation("write", path)) {
    case FAIL:
      return -1;
    case SHORT:
      full = 1;
      if (n > 1) return syscall(SYS_pwrite64, fd, bytes, n / 2, to);
      errno = ENOSPC;
      return -1;
  }
  ssize_t wrote = syscall(SYS_pwrite64, fd, bytes, n, to);
  if (wrote > 0) data(fd, path, bytes, wrote, to);
  return wrote;
}

ssize_t pwrite(int fd, const void *bytes, size_t n, off_t to) { return pwrite64(fd, bytes, n, to); }

/* Whoever copies by these goes on with read and write. */
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

ssize_t splice(int a, off64_t *b, int c, off64_t *d, size_t e, unsigned f) {
  (void)a, (void)b, (void)c, (void)d, (void)e, (void)f;
  errno = ENOSYS;
  return -1;
}

static int synced(const char *name, int fd, long number) {
  char path[PATH_MAX];
  if (!only_stdout && of_descriptor(path, fd) && inside(path)) {
    if (operation(name, path)) return -1;
    if (no_sync) {
      errno = ENOTSUP;
      return -1;
    }
    int result = syscall(number, fd);
    if (!result) done("sync\t%s\n", path);
    return result;
  }
  return syscall(number, fd);
}

int fsync(int fd) { return synced("sync", fd, SYS_fsync); }
int fdatasync(int fd) { return synced("sync", fd, SYS_fdatasync); }

int ftruncate64(int fd, off64_t length) {
  char path[PATH_MAX];
  if (!only_stdout && of_descriptor(path, fd) && inside(path)) {
    if (operation("truncate", path)) return -1;
    int result = syscall(SYS_ftruncate, fd, length);
    if (!result) done("truncate\t%s\t%ld\n", path, (long)length);
    return result;
  }
  return syscall(SYS_ftruncate, fd, length);
}

int ftruncate(int fd, off_t length) { return ftruncate64(fd, length); }

static int opened(int folder, const char *path, int flags, mode_t mode) {
  char full_path[PATH_MAX];
  whole(full_path, path);
  int writes = flags & (O_CREAT | O_WRONLY | O_RDWR);
  if (only_stdout || !writes || folder != AT_FDCWD || !inside(full_path))
    return syscall(SYS_openat, folder, path, flags, mode);
  struct stat before;
  int there = !fstatat(AT_FDCWD, path, &before, AT_SYMLINK_NOFOLLOW);
  if (operation("open", full_path)) return -1;
  int fd = syscall(SYS_openat, folder, path, flags, mode);
  if (fd >= 0 && !there) done("create\t%s\n", full_path);
  if (fd >= 0 && there && flags & O_TRUNC) done("truncate\t%s\t0\n", full_path);
  return fd;
}

#define MODE                       \
  mode_t mode = 0;                 \
  if (flags & (O_CREAT | O_TMPFILE)) { \
    va_list list;                  \
    va_start(list, flags);         \
    mode = va_arg(list, mode_t);   \
    va_end(list);                  \
  }

int open64(const char *path, int flags, ...) { MODE return opened(AT_FDCWD, path, flags | O_LARGEFILE, mode); }
int open(const char *path, int flags, ...) { MODE return opened(AT_FDCWD, path, flags, mode); }
int openat64(int folder, const char *path, int flags, ...) { MODE return opened(folder, path, flags | O_LARGEFILE, mode); }
int openat(int folder, const char *path, int flags, ...) { MODE return opened(folder, path, flags, mode); }

int rename(const char *from, const char *to) {
  char a[PATH_MAX], b[PATH_MAX];
  whole(a, from);
  whole(b, to);
  if (only_stdout || !(inside(a) || inside(b)))
    return syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0);
  if (operation("rename", b)) return -1;
  int result = syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0);
  if (!result) done("rename\t%s\t%s\n", a, b);
  return result;
}

int mkdir(const char *path, mode_t mode) {
  char full_path[PATH_MAX];
  whole(full_path, path);
  if (only_stdout || !inside(full_path)) return syscall(SYS_mkdirat, AT_FDCWD, path, mode);
  if (operation("mkdir", full_path)) return -1;
  int result = syscall(SYS_mkdirat, AT_FDCWD, path, mode);
  if (!result) done("mkdir\t%s\n", full_path);
  return result;
}

int fchmod(int fd, mode_t mode) {
  char path[PATH_MAX];
  if (!only_stdout && of_descriptor(path, fd) && inside(path) && operation("chmod", path)) return -1;
  return syscall(SYS_fchmod, fd, mode);
}

/* Taking away does not fail here: what cannot be taken away is litter. */
int unlink(const char *path) {
  char full_path[PATH_MAX];
  whole(full_path, path);
  int result = syscall(SYS_unlinkat, AT_FDCWD, path, 0);
  if (!result && inside(full_path)) done("unlink\t%s\n", full_path);
  return result;
}

int rmdir(const char *path) {
  char full_path[PATH_MAX];
  whole(full_path, path);
  int result = syscall(SYS_unlinkat, AT_FDCWD, path, AT_REMOVEDIR);
  if (!result && inside(full_path)) done("rmdir\t%s\n", full_path);
  return result;
}

// Preloaded into a program: writes down every call that concerns files below a folder, and lets
// one of them fail. The environment says what is done:
//
//   FAULTS_FOLDER   absolute path of the folder, without links
//   FAULTS_LOG      file to which one line is added for every call:
//                   subcommand, call, its number, 1 if the fault is in it, errno (-1: killed), path
//   FAULTS_COMMAND  subcommand whose process is hit: the parent and its children inherit the library
//   FAULTS_CALL     which call is hit
//   FAULTS_AT       number of the call that is hit; the first is 1, and each call has its own count
//   FAULTS_ACTION   an errno, or `short` (half is written), `full` (half is written, and then
//                   nothing more), `torn` (half is written, then the process is killed), `before`
//                   and `after` (the process is killed then)
//   FAULTS_LASTING  `call`: all later calls of the kind fail, too; `file`: those of the same file

#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

enum call { OPEN_READ, OPEN_WRITE, WRITE, SYNC, RENAME, LINK, LOCK, TRUNCATE, MKDIR, REMOVE, CALLS };
static const char *const names[CALLS] = {"open-read", "open-write", "write",    "sync",  "rename",
                                         "link",      "lock",       "truncate", "mkdir", "remove"};

enum action { PASS, FAIL, SHORT, FULL, TORN, BEFORE, AFTER };

enum lasting { ONCE, CALL, SAME_FILE };

static char folder[PATH_MAX], command[32], file_that_is_hit[PATH_MAX];
static int out = -1, target = CALLS, error_number;
static enum lasting lasting = ONCE;
static long at;
static enum action action = PASS;
static atomic_long counts[CALLS];
static atomic_int disk_is_full;

// One call while it is made.
struct met {
  enum call call;
  long number;
  enum action action;
  char path[PATH_MAX];
};

__attribute__((constructor)) static void begin(int argc, char **argv) {
  const char *log = getenv("FAULTS_LOG"), *root = getenv("FAULTS_FOLDER");
  if (!log || !root) return;
  snprintf(folder, sizeof folder, "%s", root);
  snprintf(command, sizeof command, "%s", argc > 1 ? argv[1] : "-");
  out = syscall(SYS_openat, AT_FDCWD, log, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  const char *hit = getenv("FAULTS_COMMAND"), *call = getenv("FAULTS_CALL");
  const char *number = getenv("FAULTS_AT"), *what = getenv("FAULTS_ACTION");
  if (!hit || !call || !number || !what || strcmp(hit, command)) return;
  for (target = 0; target < CALLS && strcmp(call, names[target]);) target++;
  at = atol(number);
  const char *last = getenv("FAULTS_LASTING");
  lasting = !last ? ONCE : strcmp(last, "call") ? SAME_FILE : CALL;
  error_number = atoi(what);
  action = error_number              ? FAIL
           : !strcmp(what, "short")  ? SHORT
           : !strcmp(what, "full")   ? FULL
           : !strcmp(what, "torn")   ? TORN
           : !strcmp(what, "before") ? BEFORE
                                     : AFTER;
}

static void *next(const char *name) {
  void *function = dlsym(RTLD_NEXT, name);
  if (!function) abort();
  return function;
}

static void of_descriptor(int fd, char *path) {
  char link[64];
  snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  ssize_t length = syscall(SYS_readlinkat, AT_FDCWD, link, path, PATH_MAX - 1);
  path[length > 0 ? length : 0] = 0;
}

static void of_name(int at_fd, const char *name, char *path) {
  if (name[0] == '/') {
    snprintf(path, PATH_MAX, "%s", name);
    return;
  }
  char start[PATH_MAX];
  if (at_fd == AT_FDCWD) {
    if (!getcwd(start, sizeof start)) start[0] = 0;
  } else {
    of_descriptor(at_fd, start);
  }
  if (snprintf(path, PATH_MAX, "%s/%s", start, name) >= PATH_MAX) path[0] = 0;
}

// Whether this is the thread that counts in the file of a cell: it runs beside the others, so its
// calls come in any order, and what it cannot write is like what comes late.
static int is_beside(void) {
  char name[16] = "";
  return !prctl(PR_GET_NAME, name) && !strcmp(name, "claim");
}

// Whether the call concerns the folder; then it is counted, and its action is decided.
static int meet(struct met *met, enum call call) {
  size_t length = strlen(folder);
  if (out < 0 || strncmp(met->path, folder, length)) return 0;
  if (met->path[length] && met->path[length] != '/') return 0;
  if (strstr(met->path + length, "/../") || is_beside()) return 0;
  met->call = call;
  met->number = atomic_fetch_add(&counts[call], 1) + 1;
  met->action = PASS;
  int needs_space = call == WRITE || call == OPEN_WRITE || call == LINK || call == MKDIR;
  if (needs_space && atomic_load(&disk_is_full)) {
    met->action = FAIL;
  } else if ((int)call == target && met->number >= at) {
    if (met->number == at) strcpy(file_that_is_hit, met->path);
    int again = lasting == CALL || (lasting == SAME_FILE && !strcmp(file_that_is_hit, met->path));
    if (met->number == at || again) met->action = action;
  }
  return 1;
}

static void note(const struct met *met, int error) {
  char line[PATH_MAX + 128];
  int length = snprintf(line, sizeof line, "%s %s %ld %d %d %s\n", command, names[met->call],
                        met->number, met->action != PASS, error, met->path + strlen(folder));
  if (syscall(SYS_write, out, line, (size_t)length) != length) abort();
}

static void end(void) {
  syscall(SYS_kill, getpid(), SIGKILL);
  for (;;) pause();
}

// What is done before the call; whether it fails.
static int fails(const struct met *met) {
  if (met->action == BEFORE) {
    note(met, -1);
    end();
  }
  if (met->action != FAIL) return 0;
  errno = atomic_load(&disk_is_full) ? ENOSPC : error_number;
  note(met, errno);
  return 1;
}

// What is done after the call.
static void finish(const struct met *met, long result) {
  int error = result < 0 ? errno : 0;
  note(met, error);
  if (met->action == AFTER || met->action == TORN) end();
  if (met->action == FULL) atomic_store(&disk_is_full, 1);
  errno = error;
}

// A call that returns a number, and -1 for an error.
#define PASS_ON(kind, find, real)       \
  do {                                  \
    struct met met;                     \
    find;                               \
    if (!meet(&met, kind)) return real; \
    if (fails(&met)) return -1;         \
    long result = real;                 \
    finish(&met, result);               \
    return result;                      \
  } while (0)

static enum call kind_of(int flags) {
  return flags & (O_CREAT | O_WRONLY | O_RDWR) ? OPEN_WRITE : OPEN_READ;
}

#define OPEN_MODE(flags)         \
  mode_t mode = 0;               \
  if (flags & O_CREAT) {         \
    va_list rest;                \
    va_start(rest, flags);       \
    mode = va_arg(rest, mode_t); \
    va_end(rest);                \
  }

int open64(const char *name, int flags, ...) {
  OPEN_MODE(flags)
  int (*real)(const char *, int, ...) = next("open64");
  PASS_ON(kind_of(flags), of_name(AT_FDCWD, name, met.path),
          real(name, flags, mode));
}

int open(const char *name, int flags, ...) {
  OPEN_MODE(flags)
  int (*real)(const char *, int, ...) = next("open");
  PASS_ON(kind_of(flags), of_name(AT_FDCWD, name, met.path),
          real(name, flags, mode));
}

int openat64(int fd, const char *name, int flags, ...) {
  OPEN_MODE(flags)
  int (*real)(int, const char *, int, ...) = next("openat64");
  PASS_ON(kind_of(flags), of_name(fd, name, met.path),
          real(fd, name, flags, mode));
}

ssize_t write(int fd, const void *bytes, size_t count) {
  ssize_t (*real)(int, const void *, size_t) = next("write");
  struct met met;
  of_descriptor(fd, met.path);
  if (!meet(&met, WRITE)) return real(fd, bytes, count);
  if (fails(&met)) return -1;
  int half = met.action == SHORT || met.action == FULL || met.action == TORN;
  ssize_t result = real(fd, bytes, half ? (count + 1) / 2 : count);
  finish(&met, result);
  return result;
}

// A short write of several buffers ends in the first.
ssize_t writev(int fd, const struct iovec *buffers, int count) {
  ssize_t (*real)(int, const struct iovec *, int) = next("writev");
  struct met met;
  of_descriptor(fd, met.path);
  if (!meet(&met, WRITE)) return real(fd, buffers, count);
  if (fails(&met)) return -1;
  struct iovec first = *buffers;
  first.iov_len = (first.iov_len + 1) / 2;
  int half = met.action == SHORT || met.action == FULL || met.action == TORN;
  ssize_t result = half ? real(fd, &first, 1) : real(fd, buffers, count);
  finish(&met, result);
  return result;
}

int fsync(int fd) {
  int (*real)(int) = next("fsync");
  PASS_ON(SYNC, of_descriptor(fd, met.path), real(fd));
}

int fdatasync(int fd) {
  int (*real)(int) = next("fdatasync");
  PASS_ON(SYNC, of_descriptor(fd, met.path), real(fd));
}

// The name that the file gets is the one that is written down.
int rename(const char *from, const char *to) {
  int (*real)(const char *, const char *) = next("rename");
  PASS_ON(RENAME, of_name(AT_FDCWD, to, met.path), real(from, to));
}

int linkat(int from_fd, const char *from, int to_fd, const char *to, int flags) {
  int (*real)(int, const char *, int, const char *, int) = next("linkat");
  PASS_ON(LINK, of_name(to_fd, to, met.path), real(from_fd, from, to_fd, to, flags));
}

int flock(int fd, int operation) {
  int (*real)(int, int) = next("flock");
  PASS_ON(LOCK, of_descriptor(fd, met.path), real(fd, operation));
}

int ftruncate64(int fd, off64_t length) {
  int (*real)(int, off64_t) = next("ftruncate64");
  PASS_ON(TRUNCATE, of_descriptor(fd, met.path), real(fd, length));
}

int mkdir(const char *name, mode_t mode) {
  int (*real)(const char *, mode_t) = next("mkdir");
  PASS_ON(MKDIR, of_name(AT_FDCWD, name, met.path), real(name, mode));
}

int unlink(const char *name) {
  int (*real)(const char *) = next("unlink");
  PASS_ON(REMOVE, of_name(AT_FDCWD, name, met.path), real(name));
}

int unlinkat(int fd, const char *name, int flags) {
  int (*real)(int, const char *, int) = next("unlinkat");
  PASS_ON(REMOVE, of_name(fd, name, met.path), real(fd, name, flags));
}

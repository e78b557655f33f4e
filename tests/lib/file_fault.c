/* A preloaded library that imitates a failing file system, or a power failure.
 *
 * CML_FAULT="CALL N ACTION [NAME]" hits the N-th call ("N+": and all later ones) of CALL: open (for
 * writing), write, fsync, close, rename, link, unlink or ftruncate. Only calls on files in the folder
 * CML_FAULT_FOLDER (absolute, no links, "/" at its end) and on the folder itself, called ".", count. With
 * NAME only calls on that file count; for rename and link, NAME is the new name. A temporary file
 * ("FILE.PID-N.tmp") is called "FILE.tmp". Values of ACTION:
 *
 *   before, after   SIGKILL before the call, or after it
 *   stop            SIGSTOP before the call, which is made after SIGCONT
 *   half            SIGKILL when half of a write is made
 *   short           half of a write is made, and its caller is told so
 *   lost            a write is not made, and its caller is told that it was
 *   a number        the call is not made and fails with this errno; close closes all the same
 *
 * CML_FAULT_LOG names a file to which each call is appended: "CALL NAME".
 * SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

static void note_call(const char *call, const char *name)
{
    char line[400];
    const char *log = getenv("CML_FAULT_LOG");
    if (!log) return;
    const int length = snprintf(line, sizeof line, "%s %s\n", call, name);
    const int file = (int)syscall(SYS_openat, AT_FDCWD, log, O_WRONLY | O_CREAT | O_APPEND, 0666);
    if (file < 0) return;
    syscall(SYS_write, file, line, (size_t)length);
    syscall(SYS_close, file);
}

/* Copies a name without the numbers of a temporary file, and without the text that the system adds to the
 * name of a removed file. */
static void plain_name(const char *name, char plain[300])
{
    static const char ending[] = ".tmp", removed[] = " (deleted)";
    size_t length = (size_t)snprintf(plain, 300, "%.290s", name);
    if (length > strlen(removed) && strcmp(plain + length - strlen(removed), removed) == 0)
        plain[length -= strlen(removed)] = '\0';
    if (length <= strlen(ending) || strcmp(plain + length - strlen(ending), ending) != 0) return;
    char *end = plain + length - strlen(ending);
    while (end > plain && strchr("0123456789-", end[-1])) end--;
    strcpy(end > plain && end[-1] == '.' ? end - 1 : end, ending);
}

/* Returns the action for this call, or NULL for none. */
static const char *action_for(const char *call, const char *path)
{
    static atomic_int calls;
    static char action[16];
    char named[16], number[16], aimed[256] = "", name[300];
    const char *folder = getenv("CML_FAULT_FOLDER"), *text = getenv("CML_FAULT");
    const size_t length = folder ? strlen(folder) : 0;
    if (length == 0 || strncmp(path, folder, length - 1) != 0) return NULL;
    if (path[length - 1] != '/' && path[length - 1] != '\0') return NULL;
    plain_name(path[length - 1] ? path + length : ".", name);
    note_call(call, name);
    if (!text || sscanf(text, "%15s %15s %15s %255s", named, number, action, aimed) < 3) return NULL;
    if (strcmp(named, call) != 0 || (aimed[0] && strcmp(aimed, name) != 0)) return NULL;
    const int n = atomic_fetch_add(&calls, 1) + 1, first = atoi(number);
    return n == first || (n > first && strchr(number, '+')) ? action : NULL;
}

static void die(void)
{
    kill(getpid(), SIGKILL);
    for (;;) pause();
}

/* True if the call is to be made. Otherwise sets errno. */
static int begin_call(const char *action)
{
    if (!action) return 1;
    if (strcmp(action, "before") == 0) die();
    if (strcmp(action, "stop") == 0) kill(getpid(), SIGSTOP);
    if (atoi(action) == 0) return 1;
    errno = atoi(action);
    return 0;
}

static void end_call(const char *action)
{
    if (action && strcmp(action, "after") == 0) die();
}

/* Returns the name of an open file. */
static const char *name_of(int file, char *name, size_t size)
{
    char link[64];
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    const ssize_t length = readlink(link, name, size - 1);
    name[length > 0 ? length : 0] = '\0';
    return name;
}

/* The body of a wrapped CALL on a name. The last argument is the real call. */
#define ON_NAME(call, path, ...)                                                                             \
    const char *action = action_for(call, path);                                                             \
    if (!begin_call(action)) return -1;                                                                      \
    const int result = __VA_ARGS__;                                                                          \
    end_call(action);                                                                                        \
    return result

#define ON_FILE(call, file, ...)                                                                             \
    char name[4096];                                                                                         \
    ON_NAME(call, name_of(file, name, sizeof name), __VA_ARGS__)

static int open_named(int (*real)(const char *, int, ...), const char *path, int flags, unsigned mode)
{
    if ((flags & O_ACCMODE) == O_RDONLY) return real(path, flags, mode);
    ON_NAME("open", path, real(path, flags, mode));
}

#define OPEN(name)                                                                                           \
    int name(const char *path, int flags, ...)                                                               \
    {                                                                                                        \
        va_list rest;                                                                                        \
        va_start(rest, flags);                                                                               \
        const unsigned mode = flags & O_CREAT ? va_arg(rest, unsigned) : 0;                                  \
        va_end(rest);                                                                                        \
        return open_named(REAL(name), path, flags, mode);                                                    \
    }
OPEN(open)
OPEN(open64)

static ssize_t write_named(int file, const void *data, size_t size, off64_t place)
{
    char name[4096];
    const char *action = action_for("write", name_of(file, name, sizeof name));
    const int half = action && (strcmp(action, "half") == 0 || strcmp(action, "short") == 0);
    const size_t part = half ? (size + 1) / 2 : size;
    if (!begin_call(action)) return -1;
    if (action && strcmp(action, "lost") == 0) return (ssize_t)size;
    const ssize_t done = place < 0 ? REAL(write)(file, data, part) : REAL(pwrite64)(file, data, part, place);
    if (half && strcmp(action, "half") == 0) die();
    end_call(action);
    return done;
}

ssize_t write(int file, const void *data, size_t size)
{
    return write_named(file, data, size, -1);
}

ssize_t pwrite(int file, const void *data, size_t size, off_t place)
{
    return write_named(file, data, size, place);
}

ssize_t pwrite64(int file, const void *data, size_t size, off64_t place)
{
    return write_named(file, data, size, place);
}

int fsync(int file)
{
    ON_FILE("fsync", file, REAL(fsync)(file));
}

int ftruncate(int file, off_t size)
{
    ON_FILE("ftruncate", file, REAL(ftruncate)(file, size));
}

int ftruncate64(int file, off64_t size)
{
    ON_FILE("ftruncate", file, REAL(ftruncate64)(file, size));
}

int close(int file)
{
    char name[4096];
    const char *action = action_for("close", name_of(file, name, sizeof name));
    const int made = begin_call(action), reason = errno;
    const int result = REAL(close)(file);
    end_call(action);
    if (!made) errno = reason;
    return made ? result : -1;
}

int rename(const char *from, const char *to)
{
    ON_NAME("rename", to, REAL(rename)(from, to));
}

int link(const char *from, const char *to)
{
    ON_NAME("link", to, REAL(link)(from, to));
}

int unlink(const char *path)
{
    ON_NAME("unlink", path, REAL(unlink)(path));
}

int remove(const char *path)
{
    ON_NAME("unlink", path, REAL(remove)(path));
}

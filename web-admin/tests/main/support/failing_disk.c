/* A disk that fails on demand, preloaded into a service: what is written to a file whose path holds a word fails as the
 * control file says. The control file, named by the environment, holds an errno and the word; without it nothing fails. */

#define _GNU_SOURCE
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <unistd.h>

static int fault(int fd)
{
    const char *control = getenv("STYLET_FAILING_DISK");
    FILE *file = control ? fopen(control, "r") : NULL;
    if (!file)
        return 0;
    int code = 0;
    char word[256] = "";
    int read = fscanf(file, "%d %255s", &code, word);
    fclose(file);
    char link[64], path[4096];
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (read != 2 || length < 0)
        return 0;
    path[length] = 0;
    return strstr(path, word) ? code : 0;
}

static ssize_t fail(int code)
{
    errno = code;
    return -1;
}

ssize_t write(int fd, const void *bytes, size_t length)
{
    int code = fault(fd);
    return code ? fail(code) : syscall(SYS_write, fd, bytes, length);
}

ssize_t pwrite64(int fd, const void *bytes, size_t length, off64_t offset)
{
    int code = fault(fd);
    return code ? fail(code) : syscall(SYS_pwrite64, fd, bytes, length, offset);
}

ssize_t pwrite(int fd, const void *bytes, size_t length, off_t offset)
{
    return pwrite64(fd, bytes, length, offset);
}

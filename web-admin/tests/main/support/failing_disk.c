/* A disk that fails on demand, preloaded into a service: what is written to a file whose path holds a word fails as the
 * control file says. The control file, named by the environment, holds an errno and the word; without it nothing fails. A process
 * that is called with the word as its first argument dies at once; with "first/other" where it has both as arguments. */

#define _GNU_SOURCE
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <unistd.h>

/* What the control file says; 0 without one. */
static int control(char word[256])
{
    const char *path = getenv("STYLET_FAILING_DISK");
    FILE *file = path ? fopen(path, "r") : NULL;
    if (!file)
        return 0;
    int code = 0;
    int read = fscanf(file, "%d %255s", &code, word);
    fclose(file);
    return read == 2 ? code : 0;
}

__attribute__((constructor)) static void die(int count, char **arguments)
{
    char word[256] = "";
    if (!control(word) || count < 2)
        return;
    char *other = strchr(word, '/');
    if (other)
        *other++ = 0;
    if (strcmp(arguments[1], word) != 0)
        return;
    for (int i = 1; i < count; i++)
        if (!other || strncmp(arguments[i], other, strlen(other)) == 0)
            abort();
}

static int fault(int fd)
{
    char word[256] = "";
    int code = control(word);
    if (!code)
        return 0;
    char link[64], path[4096];
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (length < 0)
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

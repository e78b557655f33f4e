/* The cache of program binaries, kept from run to run because compiling the kernels takes time. A file holds
 * a line with lengths and checksum, the key, and the binary. The key is stored in full, because different
 * keys may have the same hash.
 * SPDX-License-Identifier: MIT */
#include "engine/opencl/opencl_parts.h"

#include "base/atomic_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define MAGIC "clustermcml-opencl-1"

/* Returns FNV-1a [Fowler, Noll, Vo] of the data. It names files and finds damaged ones. It need not withstand
 * an attacker, who could not write here. */
static uint64_t hash(const void *data, size_t size)
{
    const unsigned char *bytes = data;
    uint64_t h = 0xcbf29ce484222325u;
    for (size_t i = 0; i < size; i++) h = (h ^ bytes[i]) * 0x100000001b3u;
    return h;
}

static bool ensure_directory(const char *path)
{
    return mkdir(path, 0700) == 0 || errno == EEXIST;
}

/* Finds the folder of the cache, and makes it. Returns false if there is no place for a cache. */
static bool find_folder(char folder[960])
{
    const char *base = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    int length = -1;
    if (base && base[0] == '/')
        length = snprintf(folder, 960, "%s", base);
    else if (home && home[0] == '/')
        length = snprintf(folder, 960, "%s/.cache", home);
    if (length < 0 || (size_t)length + sizeof "/clustermcml" > 960) return false;
    if (!ensure_directory(folder)) return false;
    strcat(folder, "/clustermcml");
    return ensure_directory(folder);
}

/* Names the file of a key by the key's hash. */
static void name_file(const char *key, char name[32])
{
    snprintf(name, 32, "%016llx.bin", (unsigned long long)hash(key, strlen(key)));
}

/* True if an opened file or folder belongs to the user, and nobody else may write there, because the content
 * of the cache is run. The open descriptor is checked, since a name may mean something else the next
 * moment. */
static bool is_own(int file, mode_t kind)
{
    struct stat about;
    return fstat(file, &about) == 0 && (about.st_mode & S_IFMT) == kind && about.st_uid == geteuid() &&
           (about.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

/* Returns a descriptor of a file or folder of the cache. Returns -1 if there is none, or if it may not be
 * used: then with a note, one for all devices and runs of a process. Never follows a link, nor waits for a
 * pipe. */
static int open_own(int folder, const char *name, mode_t kind, cml_opencl_note *on_note)
{
    static atomic_bool told;
    const int file = openat(folder, name, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (file < 0 && errno == ENOENT) return -1;
    if (file >= 0 && is_own(file, kind)) return file;
    if (file >= 0) close(file);
    char text[1200];
    snprintf(
        text, sizeof text,
        "%s in the cache of OpenCL binaries is not used (expected one of your own that others may not write)",
        name);
    if (!atomic_exchange(&told, true) && on_note) on_note(NULL, text);
    return -1;
}

/* Returns the binary of a file if the file is whole and has this very key; else NULL, and it is built
 * anew. */
static unsigned char *read_binary(FILE *file, const char *key, size_t *size)
{
    unsigned long long key_size = 0, binary_size = 0, checksum = 0;
    if (fscanf(file, MAGIC " %llu %llu %llx", &key_size, &binary_size, &checksum) != 3 || fgetc(file) != '\n')
        return NULL;
    if (key_size != strlen(key) || binary_size == 0 || binary_size > (1u << 30)) return NULL;
    const size_t total = (size_t)(key_size + binary_size);
    unsigned char *data = malloc(total);
    const bool whole = data && fread(data, 1, total, file) == total && memcmp(data, key, key_size) == 0 &&
                       hash(data + key_size, (size_t)binary_size) == checksum;
    if (!whole) {
        free(data);
        return NULL;
    }
    memmove(data, data + key_size, (size_t)binary_size);
    *size = (size_t)binary_size;
    return data;
}

/* A failure only costs a compilation, so it is not reported. */
unsigned char *cml_opencl_cache_load(const char *key, cml_opencl_note *on_note, size_t *size)
{
    char path[960], name[32];
    if (!find_folder(path)) return NULL;
    const int folder = open_own(AT_FDCWD, path, S_IFDIR, on_note);
    if (folder < 0) return NULL;
    name_file(key, name);
    const int opened = open_own(folder, name, S_IFREG, on_note);
    close(folder);
    FILE *file = opened < 0 ? NULL : fdopen(opened, "rb");
    if (!file) {
        if (opened >= 0) close(opened);
        return NULL;
    }
    unsigned char *binary = read_binary(file, key, size);
    fclose(file);
    return binary;
}

/* The file is written under another name first, so that no other process reads half a file. Its rights do not
 * depend on the umask. */
void cml_opencl_cache_store(const char *key, const unsigned char *binary, size_t size)
{
    char path[960 + 32], name[32];
    struct cml_error ignored;
    struct cml_file file;
    if (!find_folder(path)) return;
    const int folder = open_own(AT_FDCWD, path, S_IFDIR, NULL);
    if (folder < 0) return;
    close(folder);
    name_file(key, name);
    strcat(strcat(path, "/"), name);
    if (cml_file_create(path, &file, &ignored) != CML_OK) return;
    fchmod(file.descriptor, 0600);
    fprintf(file.stream, MAGIC " %zu %zu %llx\n", strlen(key), size, (unsigned long long)hash(binary, size));
    fputs(key, file.stream);
    fwrite(binary, 1, size, file.stream);
    if (cml_file_commit(&file, &ignored) != CML_OK) return;
}

/* Compiling the kernels takes time, so binaries are kept from run to run. A file of the cache: a line of
 * lengths and checksum, the key, the binary. The key is stored in full, because different keys may have the
 * same hash. SPDX-License-Identifier: MIT */
#include "engine/opencl/opencl_parts.h"

#include "base/atomic_file.h"
#include "base/text.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define MAGIC "clustermcml-opencl-1"

/* FNV-1a [Fowler, Noll, Vo]: names files and finds damaged ones. It need not withstand an attacker, who could
 * not write here. */
static uint64_t hash(const void *data, size_t size)
{
    const unsigned char *bytes = data;
    uint64_t h = 0xcbf29ce484222325u;
    for (size_t i = 0; i < size; i++) h = (h ^ bytes[i]) * 0x100000001b3u;
    return h;
}

/* Only the user may write what will be run. */
static bool ensure_directory(const char *path)
{
    return mkdir(path, 0700) == 0 || errno == EEXIST;
}

/* The file of a key; makes its directory. False where there is no place for a cache. */
static bool cache_path(const char *key, char path[1024])
{
    const char *base = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    char directory[960];
    int length = -1;
    if (base && base[0] == '/')
        length = snprintf(directory, sizeof directory, "%s", base);
    else if (home && home[0] == '/')
        length = snprintf(directory, sizeof directory, "%s/.cache", home);
    if (length < 0 || (size_t)length + sizeof "/clustermcml" > sizeof directory) return false;
    if (!ensure_directory(directory)) return false;
    strcat(directory, "/clustermcml");
    if (!ensure_directory(directory)) return false;
    snprintf(path, 1024, "%s/%016llx.bin", directory, (unsigned long long)hash(key, strlen(key)));
    return true;
}

/* The binary of a file, if the file is whole and of this very key; else NULL, and it is built anew. */
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

/* Whatever fails here only costs a compilation, so nothing is reported. */
unsigned char *cml_opencl_cache_load(const char *key, size_t *size)
{
    char path[1024];
    if (!cache_path(key, path)) return NULL;
    FILE *file = fopen(path, "rb");
    if (!file) return NULL;
    unsigned char *binary = read_binary(file, key, size);
    fclose(file);
    return binary;
}

/* Written under another name first, so that another process never reads half a file. */
void cml_opencl_cache_store(const char *key, const unsigned char *binary, size_t size)
{
    char path[1024];
    struct cml_error ignored;
    struct cml_file file;
    if (!cache_path(key, path)) return;
    if (cml_file_create(path, &file, &ignored) != CML_OK) return;
    fprintf(file.stream, MAGIC " %zu %zu %llx\n", strlen(key), size, (unsigned long long)hash(binary, size));
    fputs(key, file.stream);
    fwrite(binary, 1, size, file.stream);
    if (cml_file_commit(&file, &ignored) != CML_OK) return;
}

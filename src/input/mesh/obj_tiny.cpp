/* Reads the faces of an OBJ text with tinyobjloader, through its callbacks, so that nothing is stored twice.
 * Coordinates are not taken from it: its number parser adds up digit times power of ten, so half of all
 * numbers with 6 digits, and two thirds of those with 17, differ from strtod's correctly rounded ones, by up
 * to 5 units in the last place. SPDX-License-Identifier: MIT */
#include "input/mesh/obj_tiny.h"

#define TINYOBJLOADER_USE_DOUBLE
#define TINYOBJLOADER_IMPLEMENTATION
#include <tiny_obj_loader.h>

#include <istream>
#include <streambuf>

namespace
{

struct memory_buffer : std::streambuf {
    memory_buffer(const char *text, size_t size)
    {
        char *begin = const_cast<char *>(text); /* setg takes no const; the text is only read */
        setg(begin, begin, begin + size);
    }
};

struct collector {
    uint32_t *corner;
    size_t capacity, count;
    long long num_vertices;
};

/* Counts a vertex; its coordinates were read by our own scan. tinyobjloader calls it for every vertex. */
void take_vertex(void *user, tinyobj::real_t, tinyobj::real_t, tinyobj::real_t, tinyobj::real_t)
{
    static_cast<collector *>(user)->num_vertices++;
}

/* Takes a face. The callback gets indices as they are written: from 1, or negative from the last vertex. */
void take_face(void *user, tinyobj::index_t *indices, int num_indices)
{
    collector *faces = static_cast<collector *>(user);
    for (int i = 0; i < num_indices; i++) {
        const long long written = indices[i].vertex_index;
        const long long number = written < 0 ? faces->num_vertices + written : written - 1;
        if (faces->count < faces->capacity)
            faces->corner[faces->count] = number < 0 ? UINT32_MAX : static_cast<uint32_t>(number);
        faces->count++;
    }
}

} // namespace

/* Reads the faces of an OBJ text with tinyobjloader. Catches every exception of the library, because C code
 * calls this function. */
size_t cml_obj_tiny_corners(const char *text, size_t size, uint32_t *corner, size_t capacity)
{
    try {
        memory_buffer buffer(text, size);
        std::istream stream(&buffer);
        collector faces = {corner, capacity, 0, 0};
        tinyobj::callback_t callback;
        callback.vertex_cb = take_vertex;
        callback.index_cb = take_face;
        std::string warning, error;
        const bool good = tinyobj::LoadObjWithCallback(stream, callback, &faces, NULL, &warning, &error);
        return good && error.empty() ? faces.count : CML_OBJ_TINY_FAILED;
    } catch (...) {
        return CML_OBJ_TINY_FAILED;
    }
}

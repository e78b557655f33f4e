/* Writer of VTK's XML formats with appended raw data (VTK file formats, "XML file formats"). A text header
 * says where each array stands; then all arrays follow as they lie in memory:
 *
 *     <VTKFile ...> <DataArray ... offset="0"/> <DataArray ... offset="808"/> ...
 *     <AppendedData encoding="raw">
 *     _ [size in bytes, 8 bytes][array 1] [size][array 2] ...
 *     </AppendedData> </VTKFile>
 *
 * Offsets count from the byte behind the underscore.
 * SPDX-License-Identifier: MIT */
#include "output/files/vtk.h"

#include "base/atomic_file.h"

#include <inttypes.h>
#include <string.h>

#define LAST_LINE "</VTKFile>\n"
#define COMMENT CML_VTK_RUN "%s -->\n"

/* State of the header: where the next array will stand in the appended data. */
struct layout {
    FILE *out;
    uint64_t offset; /* offset of the next array, from the byte behind the underscore */
};

/* Describes an array in the header. Its size in bytes stands before the array, and counts in the offset of
 * the next. */
static void describe(struct layout *layout, const char *type, const char *name, size_t components,
                     uint64_t bytes)
{
    fprintf(layout->out,
            "        <DataArray type=\"%s\" Name=\"%s\" NumberOfComponents=\"%zu\" format=\"appended\" "
            "offset=\"%" PRIu64 "\"/>\n",
            type, name, components, layout->offset);
    layout->offset += sizeof bytes + bytes;
}

/* Describes fields as data of cells: a pixel, a voxel or a face has one value, its corners have none. If a
 * field has more values than cells, they are components, such as the angle bins of a pixel. */
static void describe_fields(struct layout *layout, const struct cml_field *fields, int num_fields,
                            size_t cells)
{
    fprintf(layout->out, "      <CellData>\n");
    for (int i = 0; i < num_fields; i++) {
        const size_t size = cml_field_size(&fields[i]);
        describe(layout, "Float32", fields[i].name, size / cells, size * sizeof(float));
    }
    fprintf(layout->out, "      </CellData>\n");
}

/* Writes the size of an array, which precedes its data in a VTK file. */
static void put_size(FILE *out, uint64_t bytes)
{
    fwrite(&bytes, sizeof bytes, 1, out);
}

/* Writes the numbers of a field in single precision, in blocks of BLOCK, so that a large field is never in
 * memory as a whole. */
static void put_field(FILE *out, const struct cml_field *field)
{
    enum { BLOCK = 1024 };
    double values[BLOCK];
    float rounded[BLOCK];
    const size_t size = cml_field_size(field);
    put_size(out, size * sizeof *rounded);
    for (size_t begin = 0; begin < size; begin += BLOCK) {
        const size_t count = size - begin < BLOCK ? size - begin : BLOCK;
        field->values(field->context, begin, count, values);
        for (size_t i = 0; i < count; i++) rounded[i] = (float)values[i];
        fwrite(rounded, sizeof *rounded, count, out);
    }
}

/* Writes the first lines. Numbers are in this machine's byte order, which the header names. */
static void begin_file(FILE *out, const char *type, const char *comment)
{
    const uint16_t one = 1;
    const bool little = *(const unsigned char *)&one == 1;
    fputs(CML_VTK_FIRST_LINE, out);
    if (comment[0]) fprintf(out, COMMENT, comment);
    fprintf(out,
            "<VTKFile type=\"%s\" version=\"1.0\" byte_order=\"%s\" "
            "header_type=\"UInt64\">\n  <%s",
            type, little ? "LittleEndian" : "BigEndian", type);
}

/* Ends the description of arrays and begins their binary data. */
static void begin_data(FILE *out, const char *type)
{
    fprintf(out, "    </Piece>\n  </%s>\n  <AppendedData encoding=\"raw\">\n   _", type);
}

/* Ends a VTK file with the line by which readers see that the file is whole. */
static cml_status end_file(struct cml_file *file, struct cml_error *err)
{
    fprintf(file->stream, "\n  </AppendedData>\n" LAST_LINE);
    return cml_file_commit(file, err);
}

/* Writes an image of pixels or voxels. The extents of the format count points between cells: n cells have the
 * points 0 to n. An extent of 0 in z makes a flat image, whose cells are pixels. */
cml_status cml_vti_write(const char *path, const char *comment, const struct cml_image *image,
                         const struct cml_field *fields, int num_fields, struct cml_error *err)
{
    struct cml_file file;
    CML_TRY(cml_file_create(path, &file, err));
    FILE *out = file.stream;
    char extent[96];
    struct layout layout = {.out = out};
    snprintf(extent, sizeof extent, "0 %zu 0 %zu 0 %zu", image->n[0], image->n[1], image->n[2]);
    begin_file(out, "ImageData", comment);
    fprintf(out, " WholeExtent=\"%s\" Origin=\"%.17g %.17g %.17g\" Spacing=\"%.17g %.17g %.17g\">\n", extent,
            image->origin[0], image->origin[1], image->origin[2], image->spacing[0], image->spacing[1],
            image->spacing[2]);
    fprintf(out, "    <Piece Extent=\"%s\">\n", extent);
    describe_fields(&layout, fields, num_fields, image->n[0] * image->n[1] * (image->n[2] ? image->n[2] : 1));
    begin_data(out, "ImageData");
    for (int i = 0; i < num_fields; i++) put_field(out, &fields[i]);
    return end_file(&file, err);
}

/* Writes the XML elements of a mesh's points and polygons. The numbers themselves follow later in the file,
 * as binary data. */
static void describe_faces(struct layout *layout, const struct cml_faces *faces)
{
    fprintf(layout->out, "      <Points>\n");
    describe(layout, "Float64", "Points", 3, faces->num_points * sizeof *faces->point);
    fprintf(layout->out, "      </Points>\n      <Polys>\n");
    describe(layout, "UInt32", "connectivity", 1,
             faces->num_faces * (size_t)faces->corners * sizeof *faces->corner);
    describe(layout, "Int64", "offsets", 1, faces->num_faces * sizeof(int64_t));
    fprintf(layout->out, "      </Polys>\n");
}

/* Writes the points, the corners of faces (`connectivity`), and the end of each face in the list of corners
 * (`offsets`). */
static void put_faces(FILE *out, const struct cml_faces *faces)
{
    const size_t corners = faces->num_faces * (size_t)faces->corners;
    put_size(out, faces->num_points * sizeof *faces->point);
    fwrite(faces->point, sizeof *faces->point, faces->num_points, out);
    put_size(out, corners * sizeof *faces->corner);
    fwrite(faces->corner, sizeof *faces->corner, corners, out);
    put_size(out, faces->num_faces * sizeof(int64_t));
    for (size_t i = 1; i <= faces->num_faces; i++) {
        const int64_t end = (int64_t)i * faces->corners;
        fwrite(&end, sizeof end, 1, out);
    }
}

/* Writes points and polygons with fields as a .vtp file. Points have 64 bits: in 32 bits a small facet far
 * from the axis would lose its shape. */
cml_status cml_vtp_write(const char *path, const char *comment, const struct cml_faces *faces,
                         const struct cml_field *fields, int num_fields, struct cml_error *err)
{
    struct cml_file file;
    CML_TRY(cml_file_create(path, &file, err));
    FILE *out = file.stream;
    struct layout layout = {.out = out};
    begin_file(out, "PolyData", comment);
    fprintf(out, ">\n    <Piece NumberOfPoints=\"%zu\" NumberOfPolys=\"%zu\">\n", faces->num_points,
            faces->num_faces);
    describe_faces(&layout, faces);
    describe_fields(&layout, fields, num_fields, faces->num_faces);
    begin_data(out, "PolyData");
    put_faces(out, faces);
    for (int i = 0; i < num_fields; i++) put_field(out, &fields[i]);
    return end_file(&file, err);
}

bool cml_vtk_has_comment(const char *path, const char *comment)
{
    char expected[128], found[sizeof expected];
    FILE *in = fopen(path, "rb");
    if (!in) return false;
    snprintf(expected, sizeof expected, CML_VTK_FIRST_LINE COMMENT, comment);
    const size_t length = strlen(expected), count = fread(found, 1, length, in);
    fclose(in);
    return count == length && memcmp(found, expected, length) == 0;
}

bool cml_vtk_is_whole(const char *path)
{
    char found[sizeof LAST_LINE];
    const size_t length = strlen(LAST_LINE);
    FILE *in = fopen(path, "rb");
    if (!in) return false;
    const bool whole = fseek(in, -(long)length, SEEK_END) == 0 && fread(found, 1, length, in) == length &&
                       memcmp(found, LAST_LINE, length) == 0;
    fclose(in);
    return whole;
}

/* SPDX-License-Identifier: MIT */
#include "options/command_table.h"

#include "base/text.h"

#include <string.h>

/* Begins the last sentence of the texts of compare, plot, view, brdf and profile. */
#define OF_PACKAGE "The Python package does it: needs python3, h5py, matplotlib and xarray; clustermcml "

const struct cml_command_def cml_commands[] = {
    [CML_COMMAND_RUN] = {"run", "scene.mci", 1, 1, "simulate all runs of the file",
                         "Flies the photons of all runs of the file and writes one result each. The word run "
                         "may be left out, and - reads the scene from standard input. Under mpiexec or srun "
                         "all ranks share the photons. Progress goes to standard error; a run that is "
                         "stopped leaves a checkpoint, from which --resume continues.",
                         "clustermcml samples/shapes/hihill.mci --photons 1e7 -o results\n"
                         "clustermcml samples/mcml_sample.mci --target-error 1e-3 --json\n"},
    [CML_COMMAND_PLAN] =
        {"plan", "scene.mci", 1, 1, "photons and time that an error takes, by engine and sampling",
         "Flies about a second of pilots, and prints how many photons, and how much time, a "
         "relative standard error of "
         "Rd, A and Tt takes on this machine. Where opencl flies a scene for the first time its "
         "kernels are compiled, some 15 s. Writes no file.",
         "clustermcml plan samples/thick.mci --target-error 1e-2\n"},
    [CML_COMMAND_CHECK] = {"check", "scene.mci", 1, 1, "validate; show layers, boundaries, meshes and memory",
                           "Reads the file as run does, and prints what was understood: layers with their "
                           "mean free paths, grids, how "
                           "every boundary is represented and why, mesh sizes, the memory that a run will "
                           "hold, and the totals of the "
                           "scene without its shapes. "
                           "Flies no photons but the trial ones of --tolerance.",
                           "clustermcml check samples/mixed.mci\n"
                           "clustermcml check samples/scan.mci --tolerance 0.01 --json\n"},
    [CML_COMMAND_EXACT] = {"exact", "scene.mci", 1, 1,
                           "totals of the flat scene without photons, by adding-doubling",
                           "Computes Rsp, Rd, A, Tt and the absorption of every layer to 1e-7, without "
                           "noise; with rough boundaries to some 1e-4. Shapes count as planes at "
                           "their nominal depths.",
                           "clustermcml exact samples/skin7.mci\n"},
    [CML_COMMAND_MESH] =
        {"mesh", "scene.mci", 1, 1, "write every curved boundary as OBJ",
         "Writes every boundary that is no plane as NAME.boundary<b>.obj, as a run would give it to Embree: "
         "heightfields and heightmaps become meshes that are as fine as --tolerance asks for.",
         "clustermcml mesh samples/scan.mci -o meshes --tolerance 0.01\n"},
    [CML_COMMAND_TRACE] = {"trace", "scene.mci N", 2, 2, "every event of photon N, as a table",
                           "Flies photon N (from 0) alone, with the random numbers that it has in a run with "
                           "the same options, and prints "
                           "its events, and which detectors see it.",
                           "clustermcml trace samples/ridges.mci 17\n"
                           "clustermcml trace samples/two_runs.mci 3 --run 2 --engine reference\n"},
    [CML_COMMAND_CROSSCHECK] =
        {"crosscheck", "scene.mci", 1, 1, "cones, mesh and OpenCL on the same photons, packet by packet",
         "Flies the same photons in several ways, and compares how each ended, all totals and all profiles.",
         "clustermcml crosscheck samples/shapes/hinoise.mci --photons 1e5 --dump differ.txt\n"},
    [CML_COMMAND_FURNACE] =
        {"furnace", "scene.mci", 1, 1, "is light even everywhere, as it must be? exit code 1 if not",
         "Flies diffuse light from above and below without absorption, for which the light in every "
         "turbid layer and body is known from its volume alone. So it proves that the meshes of a scene "
         "are flown as they should be. Writes no file.",
         "clustermcml furnace samples/mixed.mci --photons 1e6\n"},
    [CML_COMMAND_COMPARE] =
        {"compare", "a.mco b.mco", 2, 2, "do two results agree within their noise? exit code 1 if not",
         "Tests the totals, every bin of every array and the sums of arrays of two results "
         "on the same grid, ours or original MCML's. "
         "Prints z and a p-value that is corrected for the number of tests. " OF_PACKAGE
         "compare --help lists its options.",
         "clustermcml compare a.mco b.mco -o z.svg\n"},
    [CML_COMMAND_MERGE] = {"merge", "[scene.mci] FILE ...", 1, 65536,
                           "the parts of one run (run --part), joined: the result of the whole run",
                           "Adds up the parts of a run, or of all runs and rows that one call of run has "
                           "flown, and writes the results: the same bytes as those of one run. It reads the "
                           "scene again, by the name that the parts were called with, or from scene.mci, and "
                           "writes where they would have written, or into the folder of -o. A part that is "
                           "missing, not finished, there twice or of another run is refused by its name.",
                           "clustermcml run samples/skin7.mci --part 1/2\n"
                           "clustermcml run samples/skin7.mci --part 2/2\n"
                           "clustermcml merge skin7.mco.part*\n"},
    [CML_COMMAND_PLOT] =
        {"plot", "FILE ...", 1, 64, "draw results (.mco, .h5), curves (.csv) or sweeps (.sweep.csv)",
         "Draws r*Rd(r) and r*Tt(r), or the array that --of names, of one or more results "
         "(.mco, .h5), by its axes: as curves with bands of one standard error, maps in colours, "
         "cuts through voxels, directions as discs, facets as shaded meshes; the curves of others "
         "(.csv: place, value, standard error) dashed, heightfields dotted; or columns of the "
         "tables of sweeps (.sweep.csv) over each other. " OF_PACKAGE "plot --help lists its options.",
         "clustermcml plot a.mco b.mco report.csv -o curves.pdf\n"
         "clustermcml plot a.h5 --of phi_xyz --cut y=0 --title 'Skin, 633 nm' -o fluence.svg\n"
         "clustermcml plot skinmap.h5 --of Tt --percentile 99.9 -o map.png\n"
         "clustermcml plot a.sweep.csv --of A --over layer1.mua --by layer1.mus -o a.svg\n"},
    [CML_COMMAND_VIEW] =
        {"view", "scene.mci", 1, 1, "draw the section through a scene",
         "Draws the plane y = 0: boundaries, layers, bodies with their numbers, beams with the "
         "rays at their sides, detectors, the ends of the map. Flies no photons. " OF_PACKAGE
         "view --help lists its options.",
         "clustermcml view samples/mixed.mci -o mixed.svg\n"},
    [CML_COMMAND_BRDF] =
        {"brdf", "scene.mci", 1, 1, "reflection and transmission by directions, for renderers",
         "Flies the scene in parallel light from several angles. Writes tables with errors "
         "(.brdf.h5, .brdf.txt) and files for Mitsuba 3 and pbrt-v4 (.bsdf, .rgb.bsdf); help appearance "
         "tells what the numbers are. " OF_PACKAGE "brdf --help lists its options.",
         "clustermcml brdf samples/paint_gloss.mci -o paint --photons 1e6\n"},
    [CML_COMMAND_PROFILE] =
        {"profile", "scene.mci", 1, 1, "how far from its entry light leaves, for renderers",
         "Flies a pencil of light, and tells how much leaves at which distance: a table (.csv), curves "
         "for shaders and parameters of random walks (.json), a picture (.svg). Also needs scipy; help "
         "appearance tells what the numbers are. " OF_PACKAGE "profile --help lists its options.",
         "clustermcml profile samples/skin7.mci -o skin\n"},
    [CML_COMMAND_DEVICES] = {"devices", "", 0, 0, "OpenCL devices and their numbers, cores, Embree",
                             "Lists what photons can be flown on: cores and their vector instructions, "
                             "OpenCL devices with the numbers that "
                             "--device takes, and the version of Embree.",
                             "clustermcml devices\n"},
    [CML_COMMAND_HELP] =
        {"help", "[TOPIC]", 0, 1, "this list, or the text on a topic",
         "Prints the list of commands and pages. TOPIC is a command, an option, `options`, `keys`, a page of "
         "the "
         "manual, or a word: a line of the scene, a key, a name that --set takes, an array, or a "
         "word of the field such as fibre. For a word it prints the section of the manual, or the "
         "rows of its tables.",
         "clustermcml help run\n"
         "clustermcml help --set\n"
         "clustermcml help beam\n"
         "clustermcml help input | less\n"},
};
_Static_assert(sizeof cml_commands / sizeof *cml_commands == CML_NUM_COMMANDS, "a command without a row");

enum cml_command cml_command_find(const char *name)
{
    int command = 0;
    while (command < CML_NUM_COMMANDS && strcmp(cml_commands[command].name, name) != 0) command++;
    return (enum cml_command)command;
}

const char *cml_command_guess(const char *word)
{
    struct cml_guess guess = {.word = word, .length = strlen(word)};
    for (int i = 0; i < CML_NUM_COMMANDS; i++) cml_guess_offer(&guess, cml_commands[i].name);
    return cml_guess_best(&guess);
}

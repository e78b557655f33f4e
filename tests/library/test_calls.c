/* Tests libclustermcml by its header alone: flights at once, in slices, cancelled, refused; and that it
 * leaves its process as it was. The program is not involved: tests/library/example.sh and
 * tests/python/in_process.py compare with it. SPDX-License-Identifier: MIT */
#include "clustermcml.h"

#include <locale.h>
#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

static const char plain[] = "1.0\n1\na.mco A\n2000\n0.01 0.02\n20 15 3\n1\n1.0\n1.4 1 90 0.8 0.2\n1.0\n";

static void require(int status)
{
    if (status) fail_msg("%d: %s", status, clm_error());
}

static struct clm_scene *parsed(const char *text)
{
    struct clm_scene *scene;
    require(clm_scene_parse(text, NULL, NULL, &scene));
    return scene;
}

static struct clm_run *opened(struct clm_scene *scene, const char *option)
{
    struct clm_run *run;
    const char *const options[] = {option, NULL};
    require(clm_run_open(scene, 0, options, &run));
    return run;
}

/* Fails unless two runs have the same arrays, values and errors. */
static void assert_same(struct clm_run *a, struct clm_run *b)
{
    struct clm_array one, other;
    int i = 0;
    for (; clm_run_item(a, i, &one) == CLM_OK; i++) {
        require(clm_run_array(b, one.name, &other));
        assert_int_equal(one.count, other.count);
        assert_memory_equal(one.value, other.value, one.count * sizeof *one.value);
        assert_int_equal(!one.error, !other.error);
        if (one.error) assert_memory_equal(one.error, other.error, one.count * sizeof *one.error);
    }
    assert_true(i > 30);
}

static void slices_have_the_bits_of_one_flight(void **state)
{
    (void)state;
    struct clm_scene *scene = parsed(plain);
    struct clm_run *slices = opened(scene, "threads=2"), *whole = opened(scene, "photons=10000");
    require(clm_run_fly(slices, 1000));
    require(clm_run_fly(slices, 7001));
    require(clm_run_fly(slices, 1999));
    require(clm_run_fly(whole, 0));
    assert_same(slices, whole);
    clm_run_free(slices);
    clm_run_free(whole);
    clm_scene_free(scene);
}

static void a_run_needs_its_scene_no_more(void **state)
{
    (void)state;
    struct clm_array Rd;
    struct clm_scene *scene = parsed(plain);
    struct clm_run *run = opened(scene, NULL);
    clm_scene_free(scene);
    require(clm_run_fly(run, 0));
    require(clm_run_array(run, "Rd", &Rd));
    assert_true(Rd.value[0] > 0.1 && Rd.value[0] < 0.9 && Rd.error[0] > 0);
    clm_run_free(run);
}

static void a_refused_number_leaves_the_scene(void **state)
{
    (void)state;
    struct clm_scene *scene = parsed(plain), *same = parsed(plain);
    assert_int_equal(clm_scene_set(scene, 0, "layer1.mua", "-1"), CLM_E_INPUT);
    assert_non_null(strstr(clm_error(), "layer1.mua = -1 (expected"));
    assert_int_equal(clm_scene_set(scene, 0, "layer2.mua", "1"), CLM_E_INPUT);
    assert_int_equal(clm_scene_set(scene, 1, "layer1.mua", "1"), CLM_E_INPUT);
    struct clm_run *a = opened(scene, NULL), *b = opened(same, NULL);
    require(clm_run_fly(a, 0));
    require(clm_run_fly(b, 0));
    assert_same(a, b);
    clm_run_free(a);
    clm_run_free(b);
    clm_scene_free(scene);
    clm_scene_free(same);
}

/* A layer of the index of the media around it, without scattering, absorbs 1 - exp(-mua d). */
static const char clear[] = "1.0\n1\na.mco A\n64\n0.01 0.02\n20 15 3\n1\n1.0\n1 2 0 0 0.5\n1.0\n";

static void a_scene_is_known_without_a_flight(void **state)
{
    (void)state;
    const char *text, *A;
    struct clm_scene *scene = parsed(clear);
    require(clm_scene_exact(scene, 0, 1, &text));
    A = strstr(text, "\"A\":");
    assert_true(A && fabs(strtod(A + 4, NULL) - (1 - exp(-1))) < 1e-7);
    require(clm_scene_set(scene, 0, "layer1.mua", "4"));
    require(clm_scene_exact(scene, 0, 1, &text));
    A = strstr(text, "\"A\":");
    assert_true(A && fabs(strtod(A + 4, NULL) - (1 - exp(-2))) < 1e-7);
    require(clm_scene_check(scene, 0, 1, &text));
    assert_true(text[0] == '{' && strstr(text, "\"mua\":4.0") &&
                strchr(text, '\n') == text + strlen(text) - 1);
    require(clm_scene_check(scene, 0, 0, &text));
    assert_non_null(strstr(text, "64 photons"));
    assert_int_equal(clm_scene_check(scene, 1, 0, &text), CLM_E_INPUT);
    assert_string_equal(text, "");
    clm_scene_free(scene);
}

static void numbers_are_set_again_and_again(void **state)
{
    (void)state;
    struct clm_array mua;
    struct clm_scene *scene = parsed(plain);
    for (int i = 1; i <= 3; i++) {
        require(clm_scene_set_number(scene, 0, "layer1.mua", i / 3.0));
        require(clm_scene_set(scene, 0, "photons", "100"));
        struct clm_run *run = opened(scene, NULL);
        require(clm_run_fly(run, 0));
        require(clm_run_array(run, "layer_mua", &mua));
        assert_true(mua.value[0] == i / 3.0);
        clm_run_free(run);
    }
    clm_scene_free(scene);
}

/* A ring of radii 0.1 to 0.2 becomes one of 0.3 to 0.4: neither radius can be set alone. */
static void numbers_that_belong_together_are_set_at_once(void **state)
{
    (void)state;
    const char *const names[] = {"detector.r1", "detector.r2"};
    const double radii[] = {0.3, 0.4};
    struct clm_scene *scene = parsed(
        "1.0\n1\na.mco A\n200\n0.01 0.02\n20 15 3\ndetector ring 0.1 0.2\n1\n1.0\n1.4 1 90 0.8 0.2\n1.0\n");
    assert_int_equal(clm_scene_set_number(scene, 0, names[0], radii[0]), CLM_E_INPUT);
    require(clm_scene_set_numbers(scene, 0, 2, names, radii));
    assert_int_equal(clm_scene_set_numbers(scene, 0, 1000, names, radii), CLM_E_INPUT);
    clm_scene_free(scene);
}

/* The rows of a sweep that have come. */
struct rows {
    struct clm_scene *scene; /* the same, whose runs are compared with the rows; NULL: none are */
    int count, most;         /* the sweep is cancelled in row `most` */
};

static int take_row(void *context, int row, struct clm_run *run)
{
    struct rows *rows = context;
    assert_int_equal(row, rows->count++);
    assert_int_equal(clm_run_fly(run, 10), CLM_E_INPUT);
    if (rows->scene) {
        char path[] = "/tmp/clm_row_XXXXXX.h5";
        require(clm_scene_set(rows->scene, 0, "layer1.mua", row == 0 ? "0.5" : "2"));
        require(clm_scene_set(rows->scene, 0, "photons", row == 0 ? "500" : "700"));
        struct clm_run *alone = opened(rows->scene, NULL);
        require(clm_run_fly(alone, 0));
        assert_same(run, alone);
        clm_run_free(alone);
        close(mkstemps(path, 3));
        require(clm_run_write(run, path));
        struct stat file;
        assert_true(stat(path, &file) == 0 && file.st_size > 1000);
        unlink(path);
    }
    return rows->count == rows->most;
}

static void rows_of_a_sweep_are_runs(void **state)
{
    (void)state;
    const char *const shared[] = {"reweight", NULL};
    struct clm_scene *scene = parsed(plain);
    struct rows compared = {parsed(plain), 0, 9}, rows = {NULL, 0, 2};
    require(clm_scene_sweep(scene, NULL, "layer1.mua,photons\n0.5,500\n2,700\n", NULL, take_row, &compared));
    assert_int_equal(compared.count, 2);
    for (int i = 0; i < 2; i++) {
        rows.count = 0;
        assert_int_equal(
            clm_scene_sweep(scene, i ? shared : NULL, "layer1.mua\n1\n2\n3\n", NULL, take_row, &rows),
            CLM_E_STOPPED);
        assert_int_equal(rows.count, 2);
    }
    assert_int_equal(clm_scene_sweep(scene, NULL, "layer1.mua\n1\n-2\n", NULL, take_row, &rows), CLM_E_INPUT);
    assert_int_equal(rows.count, 2);
    assert_non_null(strstr(clm_error(), "the table:3: column 1, layer1.mua = -2"));
    clm_scene_free(compared.scene);
    clm_scene_free(scene);
}

static void options_of_files_are_refused(void **state)
{
    (void)state;
    static const char *const refused[] = {"output-dir=x", "checkpoint=1", "sweep=a.csv", "json",
                                          "quiet",        "help",         "phtons=1",    "photons=0"};
    struct clm_scene *scene;
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        const char *const options[] = {refused[i], NULL};
        assert_int_equal(clm_scene_parse(plain, NULL, options, &scene), CLM_E_INPUT);
        assert_null(scene);
        assert_true(strlen(clm_error()) > 10 && !strchr(clm_error(), '\n'));
    }
    struct clm_run *run;
    const char *const reading[] = {"tolerance=1e-2", NULL};
    scene = parsed(plain);
    assert_int_equal(clm_run_open(scene, 0, reading, &run), CLM_E_INPUT);
    assert_null(run);
    clm_scene_free(scene);
}

static int stop(void *context, uint64_t done, uint64_t total, double seconds)
{
    (void)seconds;
    if (done < total) *(int *)context = 1;
    return 1;
}

/* Light in the middle of a slab of 2000 mean free paths: a packet takes millions of steps to come out.
 * Engines give up such packets when their run is to stop. */
static const char thick[] =
    "1.0\n1\nb.mco A\n64\n1 1\n1 1 1\nbeam pencil z=1000\n1\n1.0\n1 0 1 0 2000\n1.0\n";

struct flight {
    struct clm_run *run;
    atomic_int status; /* -1: flies */
};

static void *fly(void *context)
{
    struct flight *flight = context;
    atomic_store(&flight->status, clm_run_fly(flight->run, 0));
    return NULL;
}

static void a_cancelled_run_stops_no_other(void **state)
{
    (void)state;
    pthread_t thread;
    int called = 0;
    struct clm_array Rd;
    struct clm_scene *scene = parsed(plain), *slow = parsed(thick);
    struct clm_run *endless = opened(scene, "photons=1e12"), *alone = opened(slow, "threads=2");
    struct flight other = {opened(slow, "threads=1"), -1};
    pthread_create(&thread, NULL, fly, &other);
    clm_run_on_progress(endless, stop, &called);
    do {
        assert_int_equal(clm_run_fly(endless, 0), CLM_E_STOPPED);
        assert_int_equal(called, 1);
        assert_non_null(strstr(clm_error(), "cancelled"));
    } while (atomic_load(&other.status) < 0);
    pthread_join(thread, NULL);
    assert_int_equal(atomic_load(&other.status), CLM_OK);
    require(clm_run_fly(alone, 0));
    assert_same(other.run, alone);
    assert_int_equal(clm_run_array(endless, "Rd", &Rd), CLM_E_INPUT);
    clm_run_on_progress(endless, NULL, NULL);
    require(clm_run_fly(endless, 1000));
    clm_run_free(endless);
    clm_run_free(other.run);
    clm_run_free(alone);
    clm_scene_free(scene);
    clm_scene_free(slow);
}

/* Meshes have trees of Embree, which all runs of a process share the device of. */
static void *fly_a_mesh(void *result)
{
    struct clm_array Rd;
    struct clm_scene *scene;
    struct clm_run *run;
    const char *const options[] = {"photons=300", "threads=2", "mesh-search=embree", NULL};
    if (!clm_scene_open("samples/ridges.mci", options, &scene)) {
        if (!clm_run_open(scene, 0, NULL, &run) && !clm_run_fly(run, 0) && !clm_run_array(run, "Rd", &Rd))
            *(double *)result = Rd.value[0];
        clm_run_free(run);
    }
    clm_scene_free(scene);
    return NULL;
}

static void twenty_threads_build_and_fly_meshes_at_once(void **state)
{
    (void)state;
    enum { COUNT = 20 };
    pthread_t thread[COUNT];
    double Rd[COUNT] = {0}, alone = 0;
    for (int i = 0; i < COUNT; i++) pthread_create(&thread[i], NULL, fly_a_mesh, &Rd[i]);
    for (int i = 0; i < COUNT; i++) pthread_join(thread[i], NULL);
    fly_a_mesh(&alone);
    assert_true(alone > 0);
    for (int i = 0; i < COUNT; i++) assert_true(Rd[i] == alone);
}

static void remember(void *context, const char *text)
{
    strncat(context, text, 200);
}

/* A pencil on ridges meets one point of them. */
static void notes_come_to_the_caller(void **state)
{
    (void)state;
    char text[4000] = "", told[1000] = "";
    struct clm_scene *scene;
    FILE *file = fopen("samples/ridges.mci", "r");
    assert_non_null(file);
    assert_true(fread(text, 1, sizeof text - 1, file) > 100);
    fclose(file);
    char *beam = strstr(text, "\nbeam");
    assert_non_null(beam);
    beam[1] = '#';
    clm_on_note(remember, told);
    require(clm_scene_parse(text, "samples", NULL, &scene));
    struct clm_run *run = opened(scene, "photons=1");
    clm_on_note(NULL, NULL);
    clm_run_free(run);
    clm_scene_free(scene);
    assert_non_null(strstr(told, "a pencil meets boundary 0 at one point"));
}

/* Makes a locale whose decimal point is a comma, in a folder that LOCPATH names; false if that fails. */
static int speak_german(const char *folder)
{
    char command[300];
    snprintf(command, sizeof command, "localedef -i de_DE -f UTF-8 %s/de_DE.utf8 >%s/log 2>&1", folder,
             folder);
    (void)!system(command);
    setenv("LOCPATH", folder, 1);
    return setlocale(LC_ALL, "de_DE.utf8") != NULL;
}

static void a_comma_as_decimal_point_changes_nothing(void **state)
{
    (void)state;
    char folder[] = "/tmp/clustermcml_localeXXXXXX", text[10], command[100];
    assert_non_null(mkdtemp(folder));
    const int speaks = speak_german(folder);
    snprintf(command, sizeof command, "rm -rf %s", folder);
    (void)!system(command);
    if (!speaks) skip();
    struct clm_scene *scene = parsed(plain);
    require(clm_scene_set_number(scene, 0, "layer1.mua", 0.5));
    struct clm_run *run = opened(scene, NULL);
    require(clm_run_fly(run, 0));
    assert_non_null(strstr(clm_run_json(run), "\"Rd\":0."));
    snprintf(text, sizeof text, "%.1f", 0.5);
    assert_string_equal(text, "0,5");
    setlocale(LC_ALL, "C");
    clm_run_free(run);
    clm_scene_free(scene);
}

/* Flies, refuses and writes with standard streams in a file, and handlers of signals that are known. */
static void nothing_is_printed_and_no_signal_is_handled(void **state)
{
    (void)state;
    char folder[] = "/tmp/clustermcml_quietXXXXXX", path[60];
    struct stat about;
    struct sigaction before[NSIG], now;
    struct clm_scene *scene;
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/a.mco", folder);
    FILE *said = tmpfile();
    const int out = dup(STDOUT_FILENO), err = dup(STDERR_FILENO);
    fflush(stdout);
    dup2(fileno(said), STDOUT_FILENO);
    dup2(fileno(said), STDERR_FILENO);
    for (int i = 1; i < SIGRTMIN; i++) (void)sigaction(i, NULL, &before[i]);
    const int refused = clm_scene_open("samples/none.mci", NULL, &scene);
    int status = clm_scene_open("samples/ridges.mci", NULL, &scene);
    struct clm_run *run = opened(scene, "photons=100");
    if (!status) status = clm_run_fly(run, 0);
    if (!status) status = clm_run_write(run, path);
    fflush(stdout);
    dup2(out, STDOUT_FILENO);
    dup2(err, STDERR_FILENO);
    fstat(fileno(said), &about);
    require(status);
    assert_int_equal(refused, CLM_E_INPUT);
    assert_int_equal(about.st_size, 0);
    for (int i = 1; i < SIGRTMIN; i++) {
        if (sigaction(i, NULL, &now) == 0) assert_ptr_equal(now.sa_handler, before[i].sa_handler);
    }
    assert_int_equal(stat(path, &about), 0);
    snprintf(path, sizeof path, "rm -rf %s", folder);
    (void)!system(path);
    clm_run_free(run);
    clm_scene_free(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slices_have_the_bits_of_one_flight),
        cmocka_unit_test(a_run_needs_its_scene_no_more),
        cmocka_unit_test(a_refused_number_leaves_the_scene),
        cmocka_unit_test(a_scene_is_known_without_a_flight),
        cmocka_unit_test(numbers_are_set_again_and_again),
        cmocka_unit_test(numbers_that_belong_together_are_set_at_once),
        cmocka_unit_test(rows_of_a_sweep_are_runs),
        cmocka_unit_test(options_of_files_are_refused),
        cmocka_unit_test(a_cancelled_run_stops_no_other),
        cmocka_unit_test(twenty_threads_build_and_fly_meshes_at_once),
        cmocka_unit_test(notes_come_to_the_caller),
        cmocka_unit_test(a_comma_as_decimal_point_changes_nothing),
        cmocka_unit_test(nothing_is_printed_and_no_signal_is_handled),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

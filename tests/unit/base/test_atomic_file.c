/* Tests of files that appear under their name only when they are complete, even if another process writes
 * the same file. SPDX-License-Identifier: MIT */
#include "base/atomic_file.h"
#include "lib/case_files.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>

static void assert_absent(void **state, const char *name)
{
    assert_int_equal(access(case_in_directory(state, name), F_OK), -1);
}

/* Returns the name of the temporary file within its directory. */
static const char *temporary_of(const struct cml_file *file)
{
    return strrchr(file->temporary, '/') + 1;
}

/* Checks that no temporary file is left in the directory. */
static void assert_nothing_is_left(void **state)
{
    DIR *directory = opendir(*state);
    assert_non_null(directory);
    for (struct dirent *entry; (entry = readdir(directory));)
        if (strstr(entry->d_name, ".tmp")) fail_msg("%s is left", entry->d_name);
    closedir(directory);
}

static void put(void **state, const char *name, const char *text)
{
    struct cml_error err;
    struct cml_file file;
    assert_int_equal(cml_file_create(case_in_directory(state, name), &file, &err), CML_OK);
    fputs(text, file.stream);
    assert_int_equal(cml_file_commit(&file, &err), CML_OK);
}

static void a_file_appears_at_commit(void **state)
{
    struct cml_error err;
    struct cml_file file;
    case_write_bytes(state, "out", "old", 3);
    assert_int_equal(cml_file_create(case_in_directory(state, "out"), &file, &err), CML_OK);
    fputs("new", file.stream);
    fflush(file.stream);
    case_assert_holds(state, "out", "old");
    case_assert_holds(state, temporary_of(&file), "new");
    assert_int_equal(cml_file_commit(&file, &err), CML_OK);
    case_assert_holds(state, "out", "new");
    assert_nothing_is_left(state);
    cml_file_abort(&file); /* an abort does nothing after a commit */
    case_assert_holds(state, "out", "new");
    case_remove(state, "out");
}

static void an_aborted_file_leaves_the_old_one(void **state)
{
    struct cml_error err;
    struct cml_file file;
    case_write_bytes(state, "out", "old", 3);
    assert_int_equal(cml_file_create(case_in_directory(state, "out"), &file, &err), CML_OK);
    fputs("half", file.stream);
    cml_file_abort(&file);
    assert_null(file.stream);
    assert_nothing_is_left(state);
    case_assert_holds(state, "out", "old");
    cml_file_abort(&file);
    case_remove(state, "out");
    assert_int_equal(cml_file_create(case_in_directory(state, "out"), &file, &err), CML_OK);
    cml_file_abort(&file);
    assert_absent(state, "out");
}

static void places_that_cannot_be_written(void **state)
{
    struct cml_error err;
    struct cml_file file;
    assert_int_equal(cml_file_create(case_in_directory(state, "none/out"), &file, &err), CML_E_IO);
    case_assert_fails_for(state, &err, CML_E_IO, "none/out", "cannot be written (No such file or directory)");
    assert_null(file.path);
    assert_null(file.temporary);
    assert_int_equal(mkdir(case_in_directory(state, "taken"), 0700), 0);
    assert_int_equal(cml_file_create(case_in_directory(state, "taken"), &file, &err), CML_E_IO);
    case_assert_fails_for(state, &err, CML_E_IO, "taken", "cannot be written (a directory)");
    assert_nothing_is_left(state);
    assert_int_equal(rmdir(case_in_directory(state, "taken")), 0);
}

/* A read-only directory cannot take a new file. Root may write everywhere, so the test skips this case for
 * root. */
static void a_read_only_directory_is_reported(void **state)
{
    struct cml_error err;
    struct cml_file file;
    if (geteuid() == 0) skip();
    assert_int_equal(mkdir(case_in_directory(state, "locked"), 0500), 0);
    assert_int_equal(cml_file_create(case_in_directory(state, "locked/out"), &file, &err), CML_E_IO);
    case_assert_fails_for(state, &err, CML_E_IO, "locked/out", "cannot be written (Permission denied)");
    assert_int_equal(rmdir(case_in_directory(state, "locked")), 0);
}

/* A full disk reports its error at the latest in the commit. The earlier result must survive that error. */
static void a_full_disk_keeps_the_old_file(void **state)
{
    struct cml_error err;
    struct cml_file file;
    case_write_bytes(state, "out", "old", 3);
    assert_int_equal(cml_file_create(case_in_directory(state, "out"), &file, &err), CML_OK);
    const int full = open("/dev/full", O_WRONLY);
    if (full < 0) skip();
    assert_int_equal(dup2(full, file.descriptor), file.descriptor);
    close(full);
    fputs("new", file.stream);
    assert_int_equal(cml_file_commit(&file, &err), CML_E_IO);
    case_assert_fails_for(state, &err, CML_E_IO, "out", "cannot be written (No space left on device)");
    case_assert_holds(state, "out", "old");
    assert_nothing_is_left(state);
    case_remove(state, "out");
}

/* The old file is kept under another name. If the new file cannot take its place, the old file stays under
 * its own name. */
static void the_old_file_is_kept_and_not_lost(void **state)
{
    struct cml_error err;
    struct cml_file file;
    char keep[256];
    case_path(state, "keep", keep);
    for (int round = 1; round <= 3; round++) {
        assert_int_equal(cml_file_create(case_in_directory(state, "out"), &file, &err), CML_OK);
        file.keep = keep;
        fprintf(file.stream, "%d", round);
        if (round == 3) assert_int_equal(unlink(file.temporary), 0);
        assert_int_equal(cml_file_commit(&file, &err), round == 3 ? CML_E_IO : CML_OK);
        case_assert_holds(state, "out", round == 1 ? "1" : "2");
        if (round == 1) assert_absent(state, "keep");
        if (round == 2) case_assert_holds(state, "keep", "1");
    }
    assert_nothing_is_left(state);
    case_remove(state, "out");
    case_remove(state, "keep");
}

/* The commit reads a file back and finds a disk that reports success but has not stored the bytes. */
static void what_is_there_is_compared_with_what_was_written(void **state)
{
    struct cml_error err;
    struct cml_file file;
    case_write_bytes(state, "out", "old", 3);
    for (int cut = 0; cut < 2; cut++) {
        assert_int_equal(cml_file_create(case_in_directory(state, "out"), &file, &err), CML_OK);
        fputs("new", file.stream);
        fflush(file.stream);
        if (cut)
            assert_int_equal(truncate(file.temporary, 2), 0);
        else
            assert_int_equal(pwrite(file.descriptor, "N", 1, 0), 1);
        assert_int_equal(cml_file_commit(&file, &err), CML_E_IO);
        case_assert_fails_for(state, &err, CML_E_IO, "out",
                              "cannot be written (what stands there is not what was written)");
        case_assert_holds(state, "out", "old");
        assert_nothing_is_left(state);
    }
    case_remove(state, "out");
}

/* A file that is deleted before its postponed sync does not count as a failed sync. */
static void syncs_may_wait(void **state)
{
    struct cml_error err;
    cml_file_defer_sync(true);
    put(state, "one", "1");
    put(state, "two", "2");
    case_remove(state, "one");
    cml_file_defer_sync(false);
    assert_int_equal(cml_file_sync_deferred(&err), CML_OK);
    case_assert_holds(state, "two", "2");
    assert_int_equal(cml_file_sync_deferred(&err), CML_OK);
    case_remove(state, "two");
}

/* Two writers write the same file at the same time. The last one to finish wins, and its file holds only
 * its own bytes. */
static void two_writers_do_not_mix(void **state)
{
    struct cml_error err;
    struct cml_file one, other;
    assert_int_equal(cml_file_create(case_in_directory(state, "out"), &one, &err), CML_OK);
    assert_int_equal(cml_file_create(case_in_directory(state, "out"), &other, &err), CML_OK);
    assert_string_not_equal(one.temporary, other.temporary);
    fputs("one", one.stream);
    fputs("other", other.stream);
    assert_int_equal(cml_file_commit(&one, &err), CML_OK);
    case_assert_holds(state, "out", "one");
    assert_int_equal(cml_file_commit(&other, &err), CML_OK);
    case_assert_holds(state, "out", "other");
    assert_nothing_is_left(state);
    case_remove(state, "out");
}

/* An attacker guesses the temporary name and puts a link there. The target of the link must not be written
 * to. */
static void a_link_under_the_temporary_name_is_not_followed(void **state)
{
    struct cml_error err;
    struct cml_file file;
    char guess[256], victim[256];
    case_write(state, "victim", "precious");
    case_path(state, "victim", victim);
    assert_int_equal(cml_file_create(case_in_directory(state, "out"), &file, &err), CML_OK);
    strcpy(guess, file.temporary);
    cml_file_abort(&file);
    assert_int_equal(symlink(victim, guess), 0);
    put(state, "out", "new");
    case_assert_holds(state, "victim", "precious");
    case_assert_holds(state, "out", "new");
    assert_int_equal(unlink(guess), 0);
    case_remove(state, "out");
    case_remove(state, "victim");
}

static void a_link_stays_and_its_target_is_replaced(void **state)
{
    struct cml_error err;
    struct cml_file file;
    struct stat about;
    char link[256];
    case_write(state, "target", "old");
    case_path(state, "link", link);
    assert_int_equal(symlink("target", link), 0);
    put(state, "link", "new");
    case_assert_holds(state, "target", "new");
    assert_int_equal(lstat(link, &about), 0);
    assert_true(S_ISLNK(about.st_mode));
    case_remove(state, "target");
    assert_int_equal(cml_file_create(link, &file, &err), CML_E_IO);
    case_assert_fails_for(state, &err, CML_E_IO, "link", "cannot be written (a link to nothing)");
    case_remove(state, "link");
}

static void what_is_no_regular_file_is_not_replaced(void **state)
{
    struct cml_error err;
    struct cml_file file;
    struct stat about;
    assert_int_equal(mkfifo(case_in_directory(state, "pipe"), 0600), 0);
    assert_int_equal(cml_file_create(case_in_directory(state, "pipe"), &file, &err), CML_E_IO);
    case_assert_fails_for(state, &err, CML_E_IO, "pipe", "cannot be written (no regular file)");
    case_remove(state, "pipe");
    assert_int_equal(cml_file_create("/dev/zero", &file, &err), CML_E_IO);
    assert_int_equal(cml_file_create("/dev/null", &file, &err), CML_OK);
    assert_null(file.temporary); /* otherwise the commit would harm the machine */
    fputs("anything", file.stream);
    assert_int_equal(cml_file_commit(&file, &err), CML_OK);
    assert_int_equal(stat("/dev/null", &about), 0);
    assert_true(S_ISCHR(about.st_mode));
}

/* An output name may have 250 bytes in a scene. The temporary name is longer and must still fit. */
static void long_names_have_room_for_their_temporary_ones(void **state)
{
    char path[512];
    struct cml_error err;
    struct cml_file file;
    snprintf(path, sizeof path, "%s/%0250d", (const char *)*state, 0);
    assert_int_equal(cml_file_create(path, &file, &err), CML_OK);
    assert_int_equal(cml_file_commit(&file, &err), CML_OK);
    assert_int_equal(unlink(path), 0);
}

/* A name whose temporary name would be cut off is refused when the file is opened, not at the commit. */
static void a_name_that_is_too_long_is_found_at_once(void **state)
{
    char path[512];
    struct cml_error err;
    struct cml_file file;
    snprintf(path, sizeof path, "%s/%0256d", (const char *)*state, 0);
    assert_int_equal(cml_file_create(path, &file, &err), CML_E_IO);
    assert_non_null(strstr(err.text, "(File name too long)"));
    assert_nothing_is_left(state);
}

/* The permissions of a finished file follow the user's umask, not those of a temporary file. */
static void permissions_follow_the_mask(void **state)
{
    struct stat about;
    const mode_t before = umask(027);
    put(state, "out", "");
    umask(before);
    assert_int_equal(stat(case_in_directory(state, "out"), &about), 0);
    assert_int_equal(about.st_mode & 0777, 0640);
    case_remove(state, "out");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_appears_at_commit),
        cmocka_unit_test(an_aborted_file_leaves_the_old_one),
        cmocka_unit_test(places_that_cannot_be_written),
        cmocka_unit_test(a_read_only_directory_is_reported),
        cmocka_unit_test(a_full_disk_keeps_the_old_file),
        cmocka_unit_test(the_old_file_is_kept_and_not_lost),
        cmocka_unit_test(what_is_there_is_compared_with_what_was_written),
        cmocka_unit_test(syncs_may_wait),
        cmocka_unit_test(two_writers_do_not_mix),
        cmocka_unit_test(a_link_under_the_temporary_name_is_not_followed),
        cmocka_unit_test(a_link_stays_and_its_target_is_replaced),
        cmocka_unit_test(what_is_no_regular_file_is_not_replaced),
        cmocka_unit_test(long_names_have_room_for_their_temporary_ones),
        cmocka_unit_test(a_name_that_is_too_long_is_found_at_once),
        cmocka_unit_test(permissions_follow_the_mask),
    };
    return cmocka_run_group_tests_name("atomic_file", tests, case_setup, case_teardown);
}

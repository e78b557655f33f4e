/* Tests, with a fake clock, of which signals stop a run cleanly and which end the process at once.
 * SPDX-License-Identifier: MIT */
#include "run/stop.h"

#include "lib/require.h"

#include <signal.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static long milliseconds = 5000;

/* Fake clock that replaces the C library's. */
int clock_gettime(clockid_t clock, struct timespec *t)
{
    (void)clock;
    *t = (struct timespec){.tv_sec = milliseconds / 1000, .tv_nsec = milliseconds % 1000 * 1000000};
    return 0;
}

/* Returns the exit code of a child process that gets a signal at this time; 0 if it survives. */
static int code_of(int number, long time)
{
    const pid_t child = fork();
    if (child == 0) {
        milliseconds = time;
        raise(number);
        _exit(cml_stop_requested() ? 0 : 1);
    }
    int status = 0;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status);
}

static void only_a_later_signal_ends_the_process(void **state)
{
    (void)state;
    const int numbers[] = {SIGTERM, SIGINT, SIGHUP, SIGUSR1, SIGUSR2, SIGXCPU};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) signal(numbers[i], SIG_DFL);
    cml_stop_before_flight();
    assert_int_equal(code_of(SIGTERM, 5000), 75);
    cml_stop_watch();
    assert_false(cml_stop_requested());
    assert_int_equal(code_of(SIGTERM, 5000), 0);
    raise(SIGTERM);
    assert_true(cml_stop_requested());
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        assert_int_equal(code_of(numbers[i], 5000), 0);
        assert_int_equal(code_of(numbers[i], 5999), 0);
        assert_int_equal(code_of(numbers[i], 6002), 128 + numbers[i]);
    }
    milliseconds = 5500; /* this signal does not restart the wait of one second after the first */
    raise(SIGINT);
    assert_int_equal(code_of(SIGINT, 6002), 128 + SIGINT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(only_a_later_signal_ends_the_process)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

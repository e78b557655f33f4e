#!/bin/sh
# Tests samples/slurm.sh under a real Slurm of one node, which this test starts and stops. The time limit's signal stops the
# job, and the job has itself requeued; `scontrol requeue` stops it once more. At the end it has the bytes of an undisturbed
# run. srun without PMI is refused.
# SPDX-License-Identifier: MIT
. tests/lib/cluster.sh
for tool in munged slurmctld slurmd sbatch scontrol; do
    command -v $tool >/dev/null || { echo "$tool is missing: no Slurm to test with"; exit 77; }
done
test "$(id -u)" -eq 0 || { echo "only root can start Slurm's daemons"; exit 77; }
job=

# ---- Slurm

port=$((20000 + $$ % 10000 * 2))
write_configuration() {
    cat <<END
ClusterName=test
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmctldPort=$port
SlurmdPort=$((port + 1))
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$work/munge.socket
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
SlurmdParameters=config_overrides
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
JobAcctGatherType=jobacct_gather/none
SwitchType=switch/none
ReturnToService=2
NodeName=$(hostname -s) NodeAddr=127.0.0.1 CPUs=2 RealMemory=1000
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
END
}

start_slurm() {
    chmod 711 "$work" # or munged refuses to put its socket there
    mkdir "$work/state" "$work/spool"
    head -c 1024 /dev/urandom >"$work/munge.key"
    chmod 400 "$work/munge.key"
    munged --key-file="$work/munge.key" --socket="$work/munge.socket" --pid-file="$work/munged.pid" \
        --log-file="$work/munged.log" --seed-file="$work/munge.seed" || return 1
    write_configuration >"$work/slurm.conf"
    # Nothing here needs control groups, but without their file system slurmd starts only if told so.
    grep -q '/sys/fs/cgroup' /proc/mounts || echo CgroupPlugin=disabled >"$work/cgroup.conf"
    export SLURM_CONF="$work/slurm.conf"
    began=$(date +%s)
    slurmctld -f "$SLURM_CONF" && slurmd -f "$SLURM_CONF" || return 1
    for second in 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15; do
        sinfo -h -o %T 2>/dev/null | grep -q '^idle' && return 0
        sleep 1
    done
    return 1
}

# True if a step runs or is being killed; it then has a socket in the spool folder.
steps_run() {
    test -n "$(find "$work/spool" -name "*_$job.*" 2>/dev/null)"
}

# True if the process has ended, or is a zombie whose parent has gone and for which nobody waits.
ended() { # PID
    ! grep '^State:' "/proc/$1/status" 2>/dev/null | grep -qv 'Z (zombie)'
}

stop_slurm() {
    if test -n "$job" && scancel --quiet "$job"; then
        for second in 1 2 3 4 5 6 7 8 9 10; do
            steps_run || break
            sleep 1
        done
    fi
    for daemon in slurmd slurmctld munged; do
        pid=$(cat "$work/$daemon.pid" 2>/dev/null) || continue
        kill "$pid"
        until ended "$pid"; do sleep 0.1; done
    done
}
trap 'stop_slurm 2>/dev/null; rm -rf "$work"' EXIT
trap 'exit 1' INT TERM HUP
start_slurm || { complain "Slurm does not start: $(tail -n 5 "$work"/*.log)"; finish; }

# ---- srun without PMI

expect_none() { # CODE WHAT COMMAND...: two tasks that do not see each other
    wanted=$1 what=$2 code=0
    shift 2
    srun --quiet --mpi=none --ntasks=2 "$@" plan samples/fig5.mci --target-error 0.3 >"$work/out" 2>"$work/err" </dev/null || code=$?
    test $code -eq "$wanted" || complain "srun --mpi=none, $what: exit $code: $(cat "$work/err")"
}
expect_none 2 "two tasks" "$program"
grep -q '^clustermcml: a launcher started 2 processes (SLURM_STEP_NUM_TASKS=2), but each sees only itself ' "$work/err" || complain "srun --mpi=none: $(cat "$work/err")"
expect_none 0 "tasks that are meant to be alone" env -u SLURM_STEP_NUM_TASKS "$program"

# ---- the undisturbed run: twenty-five seconds on this machine, by the fastest of three short ones: other programs may end

scene=$PWD/samples/thick.mci
script=$PWD/samples/slurm.sh
mkdir "$work/run" "$work/undisturbed"
speed=$(for turn in 1 2 3; do "$program" "$scene" --threads 2 --photons 1e6 --quiet --json -o "$work"; done |
    sed 's/.*"photons_per_s": *\([0-9]*\).*/\1/' | sort -n | tail -n 1)
photons=$((speed * 25))
expect_code 0 "$scene" --threads 2 --photons $photons --quiet -o "$work/undisturbed"

# ---- the job, which is stopped twice

# Slurm looks at time limits every 30 s and sends the signal of --signal=USR2@45 when less than 75 s are left: with a limit of
# a minute at its first look. A job submitted ten seconds before a look has flown half by then.
until test $((($(date +%s) - began) % 30)) -eq 20; do sleep 0.2; done
job=$(cd "$work/run" && CLUSTERMCML=$program sbatch --parsable --output=log --nodes=1 --ntasks-per-node=2 \
    --cpus-per-task=1 --time=00:01:00 --signal=USR2@45 "$script" "$scene" --photons $photons) || { complain "sbatch fails"; finish; }

# Prints the cores that each rank of the job may use, one line per rank.
cores_of_ranks() {
    for process in /proc/[0-9]*; do
        test "$(readlink "$process/cwd") $(readlink "$process/exe")" = "$work/run $(readlink -f "$program")" &&
            sed -n 's/^Cpus_allowed_list:[[:space:]]*//p' "$process/status"
    done
}

asked=
cores=
patience=$(($(date +%s) + 300))
while test "$(date +%s)" -lt $patience; do
    state=$(scontrol show job "$job")
    case $state in
    *JobState=PENDING*Reason=BeginTime*) # Slurm waits two minutes before it starts a requeued job; early enough that it flies at the next look
        steps_run || test $((($(date +%s) - began) % 30)) -gt 15 || scontrol update JobId="$job" StartTime=now+2 ;;
    *JobState=RUNNING*Restarts=1*)
        if test -z "$asked" && test "$(grep -c ', 2 ranks$' "$work/run/log")" -eq 2; then
            sleep 3
            cores=$(cores_of_ranks 2>/dev/null)
            cp "$work/run/log" "$work/asked.log"
            scontrol requeue "$job" && asked=1
        fi ;;
    *JobState=COMPLETED* | *JobState=FAILED* | *JobState=CANCELLED* | *JobState=TIMEOUT*) break ;;
    esac
    sleep 0.5
done
log=$(cat "$work/run/log")
restarts=$(echo "$state" | sed -n 's/.*Restarts=\([0-9]*\).*/\1/p')
case $state in
*JobState=COMPLETED*) job= ;;
*) complain "the job has not ended well: $state" ;;
esac
grep -q "^stopped with 75, requeued: scontrol requeue" "$work/asked.log" 2>/dev/null || complain "the time limit did not stop it"
test "$(echo "$cores" | wc -l)" -eq 2 || complain "not two ranks, but on cores $cores"
if test "$(nproc)" -ge 2; then
    echo "$cores" | sort -u | grep -q '[-,]' || test "$(echo "$cores" | sort -u | wc -l)" -eq 2 || complain "both ranks on core $cores"
fi
test "$restarts" -ge 2 || complain "restarted $restarts times, not twice"
# Progress never goes back, over all attempts of the job. A line "30 %" stands for up to 40 %.
back=$(echo "$log" | awk '/: stopped with/ { least = most = 100 - 100 * $5 / $7 } /^[0-9]+ %/ { least = $1; most = $1 + 10 }
    most < before { print } least > before { before = least }')
test -z "$back" || complain "an attempt began anew: $back"
expect_bits "requeued" "$work/run/thick.mco" "$work/undisturbed/thick.mco"
test -z "$(find "$work/run" -name '*.checkpoint*' -size +16k)" || complain "a checkpoint of a run that is not finished was left"
test $failures -eq 0 || echo "$log"
finish

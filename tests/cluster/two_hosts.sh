#!/bin/sh
# Tests two hosts, each a network namespace with its own address and host name. A run across both over TCP gives the bits of
# one host. If the link is cut, the run ends with a clear error, leaves no process, and can be resumed.
# SPDX-License-Identifier: MIT
. tests/lib/cluster.sh
mpiexec --version | grep -q 'Open MPI\|OpenRTE' || { echo "needs the remote shell of Open MPI's mpiexec"; exit 77; }
a=cml_a_$$ b=cml_b_$$
{ ip netns add $a && unshare --uts true; } 2>"$work/err" || { echo "no namespaces here: $(cat "$work/err")"; exit 77; }
trap 'for host in $a $b; do ip netns pids $host | xargs -r kill -9; ip netns del $host; done 2>/dev/null; rm -rf "$work"' EXIT
ip netns add $b
ip link add cml0 netns $a type veth peer name cml0 netns $b || { echo "no virtual link here"; exit 77; }
for host in "$a 10.77.0.1" "$b 10.77.0.2"; do
    set -- $host
    ip -n "$1" addr add "$2/24" dev cml0
    ip -n "$1" link set lo up
    ip -n "$1" link set cml0 up
done

# This script starts commands on the other host for mpiexec, in place of ssh.
cat >"$work/shell" <<E2
#!/bin/sh
shift
exec ip netns exec $b unshare --uts sh -c 'hostname host-b; exec sh -c "\$0"' "\$*"
E2
chmod +x "$work/shell"
printf '10.77.0.1 slots=1\n10.77.0.2 slots=1\n' >"$work/hosts"

# Runs on both hosts. mpiexec's keepalive for its own connections is set to find a lost host in 4 to 6 s; its default takes
# minutes. The program reports the loss within its patience of 3 s and gives mpiexec 6 s more.
both() { # ARGUMENTS...
    TMPDIR=$work timeout 60 ip netns exec $a unshare --uts sh -c 'hostname host-a; exec "$@"' sh \
        mpiexec --hostfile "$work/hosts" -n 2 --bind-to none --mca plm_rsh_agent "$work/shell" \
        --mca btl tcp,self --mca btl_tcp_if_include 10.77.0.0/24 --mca oob_tcp_if_include 10.77.0.0/24 \
        --mca oob_tcp_keepalive_time 2 --mca oob_tcp_keepalive_intvl 2 --mca oob_tcp_keepalive_probes 2 \
        "$program" samples/thick.mci --photons 1e6 --threads 1 -o "$work" "$@"
}

expect_code 0 samples/thick.mci --photons 1e6 --quiet -o "$work"
mv "$work/thick.mco" "$work/expected"
both --verbose >"$work/out" 2>"$work/err" || complain "two hosts: $(cat "$work/out" "$work/err")"
expect_bits "two hosts" "$work/thick.mco" "$work/expected"
awk '$1 == 1 && $2 > 1e5 { found = 1 } END { exit !found }' "$work/out" || complain "host b did nothing: $(cat "$work/out")"
rm "$work/thick.mco"

both --quiet --checkpoint 0.1 --patience 3 >"$work/out" 2>"$work/err" &
run=$!
until test -e "$work/thick.mco.checkpoint" || ! kill -0 $run; do sleep 0.05; done
ip -n $b link set cml0 down
code=0
wait $run || code=$?
# mpiexec has its own exit code for a lost host; that of Open MPI 5 is 0.
case $code,$(mpiexec --version) in
0,*"Open MPI) 5"*) ;;
0,* | 124,*) complain "link cut: exit $code" ;;
esac
grep -q '^clustermcml: contact lost: nothing heard from rank 1 on host-b for 3 s ' "$work/err" ||
    complain "link cut: $(cat "$work/err")"
for try in $(seq 100); do
    left=$(ip netns pids $a; ip netns pids $b)
    test -n "$left" || break
    sleep 0.1
done
test -z "$left" || complain "link cut: processes are left: $(ps -o args= -p "$(echo $left | tr ' ' ,)")"
test ! -e "$work/thick.mco" || complain "link cut: a result was written"

expect_code 0 samples/thick.mci --photons 1e6 --quiet --resume --threads 2 -o "$work"
expect_bits "resumed on one host" "$work/thick.mco" "$work/expected"
grep -q 'begins anew' "$work/err" && complain "there was no checkpoint"
finish

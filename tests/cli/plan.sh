#!/bin/sh
# Tests clustermcml plan: its words and exit codes, and that a run of the planned number of photons reaches the error asked
# for. Pilots have a fixed number of photons here, so nothing depends on the speed of the machine.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh

expect_error 2 "usage: clustermcml plan scene.mci (try clustermcml help plan)" plan
expect_error 2 "--target-error 1 (expected a relative error between 0 and 1)" plan samples/fig6.mci --target-error 1
expect_code 2 plan "$work/none.mci"

cp samples/fig6.mci "$work"
expect_code 0 plan "$work/fig6.mci" --target-error 0.01 --photons 4096 --threads 1
grep -q '^fig6.mco: photons and time to a relative standard error of 1 %, on 1 rank of 1 thread$' "$work/out" ||
    complain "plan: heading $(head -n 1 "$work/out")"
for row in 'cpu *lattice' 'cpu *random' 'reference *lattice' 'reference *random'; do
    grep -Eq "^  $row( +[0-9.e+-]+){2} +[0-9.e+-]+ (s|min|h|d) " "$work/out" || complain "plan: no row $row: $(cat "$work/out")"
done
grep -Eq '^  (opencl +lattice|without opencl: .*) ' "$work/out" || complain "plan: nothing of opencl: $(cat "$work/out")"
grep -q 'pilots of up to 4.1e+03 photons' "$work/out" || complain "plan: not the pilot of --photons: $(cat "$work/out")"
test ! -s "$work/err" && test "$(ls "$work")" = "$(printf 'err\nfig6.mci\nout')" || complain "plan wrote: $(ls "$work")"

# A total that fewer than four packets have shown has no plan, while Rd and A have one.
sed 's/^1.34 0.1 1 0.5 1 /1.34 90 1 0.5 0.07 /' samples/fig6.mci >"$work/dim.mci"
expect_code 0 plan "$work/dim.mci" --photons 1024 --json
grep -q '"Tt":{"photons":null,"seconds":null}' "$work/out" || complain "plan: dim slab: $(cat "$work/out")"
expect_code 0 plan "$work/dim.mci" --photons 65536 --json
grep -q '"Tt":{"photons":[0-9]' "$work/out" || complain "plan: dim slab, more photons: $(cat "$work/out")"

# plan prints the number of photons that a run with --target-error flies, from few photons in the file and from more.
for photons in 1000 30000; do
    sed "s/^1000000 /$photons /" samples/fig6.mci >"$work/few.mci"
    expect_code 0 plan "$work/few.mci" --photons 4096 --target-error 0.1
    needs=$(sed -n 's/.*--target-error needs some [0-9.e+-]* photons and flies \([^:]*\):.*/\1/p' "$work/out")
    expect_code 0 "$work/few.mci" --target-error 0.1 --json -o "$work"
    python3 -c 'import json, sys; sys.exit(float("%.2g" % json.load(open(sys.argv[1]))["photons"]) != float(sys.argv[2]))' "$work/out" "$needs" ||
        complain "plan says $needs photons: $(cat "$work/out")"
done
rm -f "$work"/fig6.mco*

# A total that no light reaches is not planned; meshes are not for devices.
sed 's/^1.34 0.1 1 0.5 1 /1.34 90 1 0.5 9 /' samples/fig6.mci >"$work/dark.mci"
expect_code 0 plan "$work/dark.mci" --photons 1024 --json
grep -q '"Tt":{"photons":null,"seconds":null}' "$work/out" || complain "plan: dark slab: $(cat "$work/out")"
expect_code 0 plan samples/shapes/hihill.mci --boundaries mesh --photons 1024
grep -q '^  without opencl: .' "$work/out" || complain "plan: a mesh for opencl: $(cat "$work/out")"

# The plan holds for a thin and a thick scene. Within the pilot it holds to a factor of 1.5 on both sides; beyond the pilot it
# is an upper estimate, because of the lattice.
for scene in shapes/hihill thick; do
    for photons in 1024 65536; do
        for sampling in lattice random; do
            python3 - "$program" samples/$scene.mci $photons $sampling "$work" <<'END' || complain "$scene, $sampling: plan not kept"
import json
import subprocess
import sys
program, scene, photons, sampling, work = sys.argv[1:]
E = 5e-3
words = [program, "plan", scene, "--json", "--target-error", str(E), "--photons", photons]
plan = json.loads(subprocess.run(words, stdout=subprocess.PIPE, check=True).stdout)
assert plan["pilot_photons"] == int(photons) and plan["error"] == E, plan
row, = [row for row in plan["plans"] if (row["engine"], row["sampling"]) == ("cpu", sampling)]
for total in ("Rd", "A"):
    planned = row[total]["photons"]
    assert abs(planned / row["photons_per_s"] / row[total]["seconds"] - 1) < 1e-9, row
    run = [program, scene, "--json", "--seed", "2", "--photons", "%.0f" % planned, "--sampling", sampling, "-o", work]
    result = json.loads(subprocess.run(run, stdout=subprocess.PIPE, check=True).stdout)
    ratio = result[total + "_se"] / result[total] / E
    print(scene, sampling, photons, total, "%.0f photons, error over that wanted %.2f" % (planned, ratio))
    upper = sampling == "lattice" and planned > int(photons)
    assert ratio < 1.5 and (upper or ratio > 1 / 1.5), (total, planned, ratio)
END
        done
    done
done

# A total that no pilot sees has no plan; one that all packets score alike takes the fewest photons.
printf '1.0\n1\nx.mco A\n1000\n1 1\n1 1 1\n1\n1.0\n1.4 0 0 0 0.1\nbacking metal 0.2 3\n1.0\n' >"$work/clear.mci"
expect_code 0 plan "$work/clear.mci"
grep -qE '^  cpu +lattice +[0-9.e+]+ +[0-9.e+]+ +[0-9.e-]+ s +- +- +- +- *$' "$work/out" || complain "plan of a clear layer: $(cat "$work/out")"
finish

#!/bin/sh
# Tests --set and --output. For every name, the result has the bytes of a file in which that number was changed by hand, but
# for the line that says so. Wrong names and values are refused in the words of the file's own reader.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh
cp meshes/ridges.obj "$work/mesh.obj"

# Writes the scene; each name=value of the arguments replaces its number.
scene() { # FILE NAME=VALUE...
    file=$1
    shift
    python3 - "$@" >"$file" <<'END'
import sys
value = {"photons": "3000", "above.n": "1", "below.n": "1.2", "beam.angle": "20", "beam.azimuth": "0", "beam.radius": "0.1",
         "layer1.n": "1.4", "layer1.mua": "1", "layer1.mus": "20", "layer1.g": "0.8", "layer1.d": "0.5", "layer2.n": "1.3",
         "layer2.mua": "0.5", "layer2.mus": "10", "layer2.g": "0", "layer2.d": "0.3", "boundary0.scale": "1",
         "boundary1.scale": "1", "boundary1.height": "1"}
value.update(word.split("=") for word in sys.argv[1:])
s, h = float(value["boundary1.scale"]), float(value["boundary1.height"]) * float(value["boundary1.scale"])
value["b"] = f"b 3 {0.0625 * h} {0.125 * s} {0.03125 * h} {0.25 * s} 0 1"
print("""1.0
1
result.mco A
{photons}
0.02 0.02
20 20 5
beam disk {beam.radius} angle={beam.angle} azimuth={beam.azimuth}
2
{above.n}
m "mesh.obj" scale={boundary0.scale}
{layer1.n} {layer1.mua} {layer1.mus} {layer1.g} {layer1.d}
{b}
{layer2.n} {layer2.mua} {layer2.mus} {layer2.g} {layer2.d}
{below.n}""".replace("{", "{v[").replace("}", "]}").format(v=value))
END
}

# Checks that the settings give the bytes of edited.mci, but for the line that says so.
same_as_edited() { # "NAME=VALUE ..." FILE
    mkdir "$work/a" "$work/b"
    expect_code 0 "$work/edited.mci" --quiet -o "$work/a"
    # shellcheck disable=SC2046
    expect_code 0 "$2" --quiet -o "$work/b" $(printf ' --set %s' $1)
    bare "$work/a/result.mco" >"$work/a.txt"
    bare "$work/b/result.mco" >"$work/b.txt"
    cmp -s "$work/a.txt" "$work/b.txt" || complain "$1: not the bytes of the edited file"
    for setting in $1; do
        grep -qx "# set ${setting%=*} = ${setting#*=}" "$work/b/result.mco" || complain "$setting is not in the result"
    done
    rm -r "$work/a" "$work/b"
}

bare() { grep -v '^# User time\|^# set ' "$1"; }

scene "$work/plain.mci"
for setting in photons=2000 above.n=1.1 below.n=1.5 layer1.n=1.5 layer1.mua=2 layer1.mus=30 layer1.g=0.5 layer1.d=0.7 \
    layer2.n=1.35 layer2.mua=0 layer2.mus=12.5 layer2.g=-0.25 layer2.d=0.75 beam.angle=45 beam.azimuth=30 beam.radius=0.2 \
    boundary0.scale=2 boundary1.scale=0.5 boundary1.height=0.5; do
    scene "$work/edited.mci" $setting
    same_as_edited $setting "$work/plain.mci"
done

# A factor for heights alone: the written mesh is half as high, and as wide as before.
expect_code 0 mesh "$work/plain.mci" -o "$work" --set boundary0.height=0.5 --quiet
awk 'NR == FNR { if ($1 == "v") plain[++n] = $2 " " $3 " " $4; next }
     $1 == "v" { split(plain[++k], p); if (p[1] != $2 || p[2] != $3 || p[3] / 2 - $4 > 1e-12 || $4 - p[3] / 2 > 1e-12) exit 1 }' \
    "$work/mesh.obj" "$work/result.mco.boundary0.obj" || complain "boundary0.height: not half as high"

# All commands that read a scene accept --set, also several times.
expect_code 0 check "$work/plain.mci" --set layer1.mua=7 --set layer2.d=0.9 --json
grep -q '"mua":7.0' "$work/out" && grep -q '"d":0.9' "$work/out" || complain "check --set: $(cat "$work/out")"
expect_code 0 exact samples/skin7.mci --set layer1.mua=0 --json
expect_code 0 trace "$work/plain.mci" 3 --set layer1.mua=7
test ! -s "$work/err" || complain "trace: $(cat "$work/err")"
expect_code 0 trace "$work/plain.mci" 3 --set photons=3
grep -qx 'clustermcml: note: photon 3 is not among those of result.mco (0 to 2, unless --photons says more)' "$work/err" ||
    complain "trace beyond the photons: $(cat "$work/err")"
expect_code 0 "$work/plain.mci" --set photons=1e3 --set layer1.mua=7 --json -o "$work"
grep -q '"set":{"photons":1000.0,"layer1.mua":7.0}' "$work/out" || complain "--json: $(cat "$work/out")"

# --set changes bodies: spheres and meshes.
body() { # NAME=VALUE of a body
    python3 - "$@" >"$work/body.mci" <<'END'
import sys
value = {f"body{k}.{name}": number for k in (1, 2) for name, number in zip(("n", "mua", "mus", "g"), ("1.5", "2", "10", "0.5"))}
value.update(word.split("=") for word in sys.argv[1:])
one, two = (" ".join(value[f"body{k}.{name}"] for name in ("n", "mua", "mus", "g")) for k in (1, 2))
print(f"""1.0
1
result.mco A
3000
0.02 0.02
20 20 5
1
1
1.4 1 20 0.8 1
i sphere 0 0 0.5 0.2 {one}
i "octahedron.obj" {two} scale=0.2 shift=0.5,0,-0.5
1
""")
END
}
printf 'v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\nf 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n' \
    >"$work/octahedron.obj"
body
cp "$work/body.mci" "$work/bodies.mci"
for setting in body1.n=1.33 body1.mua=5 body1.mus=0 body1.g=0.9 body2.n=1 body2.mua=0 body2.mus=50 body2.g=-0.5; do
    body $setting
    mv "$work/body.mci" "$work/edited.mci"
    same_as_edited $setting "$work/bodies.mci"
done
expect_error 2 "--set: body1.mua = -1 (expected a coefficient of 0..1e30 1/cm)" "$work/bodies.mci" --set body1.mua=-1
expect_error 2 "--set: body3.n = 1 (expected a name that the run in line 3 knows: photons, above.n, below.n, layer1 with .n .mua .mus .g .d, body1..2 with .n .mua .mus .g, beam with .x .y .angle .azimuth)" \
    "$work/bodies.mci" --set body3.n=1

# Detectors are set by the words of their lines.
seen() { # FILE DETECTORS
    printf '1.0\n1\nresult.mco A\n2000\n0.02 0.02\n20 20 5\n%b1\n1\n1.4 1 20 0.8 0.5\n1\n' "$2" >"$1"
}
disk='detector disk 0.1 at=0.2,0 na=0.4 angle=20\n' map='detector map 3 2 0.1 0.2 side=bottom\n'
seen "$work/seen.mci" "$disk${map}detector ring 0.1 0.2\n"
for case in 'detector1.x=0.1|disk 0.1 at=0.1,0 na=0.4 angle=20' 'detector1.y=0.3|disk 0.1 at=0.2,0.3 na=0.4 angle=20' \
    'detector1.z=-0.1|disk 0.1 at=0.2,0 z=-0.1 na=0.4 angle=20' 'detector1.radius=0.3|disk 0.3 at=0.2,0 na=0.4 angle=20' \
    'detector1.na=0.9|disk 0.1 at=0.2,0 na=0.9 angle=20' 'detector1.angle=70|disk 0.1 at=0.2,0 na=0.4 angle=70' \
    'detector1.azimuth=50|disk 0.1 at=0.2,0 na=0.4 angle=20 azimuth=50'; do
    seen "$work/edited.mci" "detector ${case#*|}\\n${map}detector ring 0.1 0.2\n"
    same_as_edited "${case%%|*}" "$work/seen.mci"
done
seen "$work/edited.mci" "${disk}detector map 3 2 0.2 0.1 side=bottom\ndetector ring 0.15 0.3\n"
same_as_edited "detector2.dx=0.2 detector2.dy=0.1 detector3.r1=0.15 detector3.r2=0.3" "$work/seen.mci"
seen "$work/whole.mci" "detector ring 0 0.2\n" # a ring has two radii, also without a hole
seen "$work/edited.mci" "detector ring 0.1 0.3\n"
same_as_edited "detector.r1=0.1 detector.r2=0.3" "$work/whole.mci"
expect_error 2 "--set: detector.radius = 0.3 (expected a name that the run in line 3 knows: photons, above.n, below.n, layer1 with .n .mua .mus .g .d, beam with .x .y .angle .azimuth, detector with .x .y .z .r1 .r2)" \
    "$work/whole.mci" --set detector.radius=0.3
expect_error 2 "--set: detector1.angle = 91 (expected degrees of 0..90)" "$work/seen.mci" --set detector1.angle=91
expect_error 2 "$work/seen.mci:9: detector: r1 r2 = 0.3 0.2 (expected r1 < r2)" "$work/seen.mci" --set detector3.r1=0.3
for name in detector1.r1 detector2.radius detector2.na detector4.x detector.x; do
    expect_error 2 "--set: $name = 0.3 (expected a name that the run in line 3 knows: photons, above.n, below.n, layer1 with .n .mua .mus .g .d, beam with .x .y .angle .azimuth, detector1 with .x .y .z .radius .na .angle .azimuth, detector2 with .x .y .z .dx .dy, detector3 with .x .y .z .r1 .r2)" \
        "$work/seen.mci" --set $name=0.3
done

names='photons, above.n, below.n, layer1..2 with .n .mua .mus .g .d, boundary0..1 with .scale .height, beam with .x .y .angle .azimuth .radius'
expect_error 2 "--set: layer3.n = 1.4 (expected a name that the run in line 3 knows: $names)" "$work/plain.mci" --set layer3.n=1.4
expect_error 2 "--set: boundary2.scale = 2 (expected a name that the run in line 3 knows: $names)" "$work/plain.mci" --set boundary2.scale=2
expect_error 2 "--set: layer1.mua = -1 (expected a coefficient of 0..1e30 1/cm)" "$work/plain.mci" --set layer1.mua=-1
expect_error 2 "--set: layer1.mua = 1e-13 (expected 0, or at least 1e-11 of mua + mus)" "$work/plain.mci" --set layer1.mua=1e-13
expect_error 2 "--set: layer1.n = x (expected a refractive index of 0.01..100)" "$work/plain.mci" --set layer1.n=x
expect_error 2 "--set: layer1.g = 1.5 (expected an anisotropy of -1..1)" "$work/plain.mci" --set layer1.g=1.5
expect_error 2 "--set: photons = 0.5 (expected a whole number of 1..2^48)" "$work/plain.mci" --set photons=0.5
expect_error 2 "--set: beam.angle = 90 (expected degrees, 0 <= angle < 90)" "$work/plain.mci" --set beam.angle=90
expect_error 2 "--set: boundary0.scale = 0 (expected a number of 1e-30..1e30)" "$work/plain.mci" --set boundary0.scale=0
expect_error 2 "--set: layer1.n = 2 (expected one value, but --set has set it to 1)" "$work/plain.mci" --set layer1.n=1 --set layer1.n=2
expect_error 2 "--set: photons = 9 (expected no value beside that of --photons)" "$work/plain.mci" --set photons=9 --photons 8
expect_error 2 "--set layer1.n (expected NAME=VALUE, like layer1.mua=0.3)" "$work/plain.mci" --set layer1.n
expect_error 2 "--set layer1.n= (expected NAME=VALUE, like layer1.mua=0.3)" "$work/plain.mci" --set layer1.n=

# --output names the result, and its ending sets the format.
expect_code 0 "$work/plain.mci" --quiet --output other.mco -o "$work"
grep -q '^other.mco' "$work/other.mco" || complain "--output other.mco"
if "$program" "$work/plain.mci" --quiet --output other.h5 -o "$work" --set layer1.mua=3 2>"$work/err"; then
    grep -aq 'layer1.mua = 3' "$work/other.h5" || complain "other.h5 does not say what was set"
else
    grep -q 'built without HDF5' "$work/err" || complain "--output other.h5: $(cat "$work/err")"
fi
expect_error 2 "--output a.mco (expected a file with one run; samples/two_runs.mci has 2)" samples/two_runs.mci --output a.mco
expect_error 2 "--output ../ (expected a file name of 1..250 bytes)" "$work/plain.mci" --output ../

# A stopped run is not continued with other values.
code=0
"$program" "$work/plain.mci" --set photons=1e9 --quiet -o "$work" --output long.mco --checkpoint 0.05 2>"$work/err" &
run=$!
until test -e "$work/long.mco.checkpoint"; do sleep 0.05; done
kill -TERM $run
wait $run || code=$?
test $code -eq 75 || complain "stopped: exit $code, $(cat "$work/err")"
expect_error 2 "$work/long.mco.checkpoint: the checkpoint is of another run: 'set photons = 1e9' there, 'set photons = 1000000000' here (expected that run; without --resume or --more this one begins anew)" \
    "$work/plain.mci" --set photons=1000000000 --quiet -o "$work" --output long.mco --resume
finish

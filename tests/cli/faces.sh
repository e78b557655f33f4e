#!/bin/sh
# Tests face and port lines from outside: where light is booked, what files and messages say, settings, what other parts of
# the program refuse. tests/cli/bad_input.cases has the messages about wrong lines.
# SPDX-License-Identifier: MIT
. tests/lib/cli.sh

# Writes $work/NAME.mci. The lines of the run, those on boundary 0 and those behind layer 1 come with \n between them.
scene() { # NAME RUN TOP BELOW
    printf '1.0\n1\n%s.mco A\n4000\n%b\n0.02 0.02\n10 10 4\n1\n1.0\n%b\n1.4 0.5 50 0.8 0.3\n%b1.0\n' "$1" "$2" "$3" "$4" |
        sed '/^$/d' >"$work/$1.mci"
}
number() { # KEY: of the JSON line in $work/out
    grep -o "\"$1\":[^],}]*" "$work/out" | sed 's/.*://;q'
}
probe='face disk 0.3 0.6\n#@ port disk 0.011 n=1.44 at=-0.011,0\nport disk 0.01 n=1.46 at=-0.011,0 name=in\nport ring 0.02 0.05 n=1.5 at=0.1,0'

# Names by default, comments of original MCML, JSON of the lines, and books of integers.
scene probe 'beam port in light=na:0.22\ndetector port in\ndetector port 3 diffuse' "$probe" ""
expect_code 0 check "$work/probe.mci" --json
grep -q '"top":\[{"kind":"face","name":null,"shape":"disk","size":\[[0-9.]*\],"x":0.0,"y":0.0,"n":null,"r":0.[56][0-9]*,"law":"mirror","k":null},{"kind":"port","name":"1","shape":"disk"' "$work/out" ||
    complain "check --json, top: $(cat "$work/out")"
grep -q '{"kind":"port","name":"3","shape":"ring","size":\[0.02[^,]*,0.05[^]]*\],"x":0.1[^,]*,"y":0.0,"n":1.5,"r":null,"law":null,"k":null}\]' "$work/out" ||
    complain "check --json, the ring: $(cat "$work/out")"
grep -q '"name":"3","shape":"ring"' "$work/out" || complain "detector port 3 has another name: $(cat "$work/out")"
grep -q '"flat":null' "$work/out" || complain "check --json has exact totals: $(cat "$work/out")"
expect_code 0 run "$work/probe.mci" --quiet --json -o "$work"
! grep -q 'A_face_exact' "$work/out" || complain "an exact A_face"
test "$(number Rsp_exact)" = null || complain "Rsp_exact is $(number Rsp_exact)"
grep -q '"residue":0.0' "$work/out" || complain "the books do not balance: $(cat "$work/out")"
awk -v face="$(number A_face)" '/^A_face #/ { getline; near = ($1 - face) ^ 2 < 1e-10 } /^se_A_face #/ { getline; error = $1 > 0 }
    END { exit !(face > 0.05 && near && error) }' "$work/probe.mco" || complain "A_face in the .mco: $(grep -A1 A_face "$work/probe.mco")"
grep -q '^# port 3: ring of radii 0.02 and 0.05 cm at (0.1 0) cm, n = 1.5$' "$work/probe.mco" || complain "the .mco has no lines of ports"

# An aperture as large as the index of the port is the half space.
scene wide 'beam port 1 light=na:1.5' 'port disk 0.01 n=1.5' ""
expect_code 0 run "$work/wide.mci" --quiet -o "$work"

# A port of n above changes no bit of a result; light that passes it is split as ever.
for beam in 'beam disk 0.1' 'beam rectangle 0.1 0.2 angle=30' 'beam pencil light=lambertian'; do
    scene open "$beam" "" ""
    scene hole "$beam" 'port disk 0.07 n=1 at=0.05,0' ""
    for name in open hole; do expect_code 0 run "$work/$name.mci" --quiet --json -o "$work"; cp "$work/out" "$work/$name.json"; done
    for key in Rsp Rd A Tt; do
        test "$(grep -o "\"$key\":[^,]*" "$work/open.json")" = "$(grep -o "\"$key\":[^,]*" "$work/hole.json")" ||
            complain "$beam: a hole changes $key"
    done
done

# A white face over everything and a backing below keep all light in a scene without absorption; a face of R = 0 takes half.
scene white 'beam pencil z=0.1 light=isotropic' 'face 1 lambertian' 'backing 0\n'
sed -i 's/1.4 0.5 50/1.4 0 50/' "$work/white.mci"
expect_code 0 run "$work/white.mci" --quiet --json -o "$work"
test "$(number A)" = 0.0 -a "$(number A_face)" = 0.0 -a "$(number A_backing)" = 1.0 || complain "a white face: $(cat "$work/out")"

# The lit fibre sees its own Fresnel reflection, unless its detector is diffuse, and its light counts in Rsp alone.
scene lit 'beam port 1\ndetector port 1\ndetector port 1 diffuse name=d' 'port disk 0.1 n=2' ""
sed -i 's/1.4 0.5 50 0.8/1.4 1e6 0 0/' "$work/lit.mci"
expect_code 0 run "$work/lit.mci" --quiet --json -o "$work"
awk -v found="$(number Rsp)" 'BEGIN { exit !((found - (0.6 / 3.4) ^ 2) ^ 2 < 1e-14) }' || complain "Rsp of a fibre is $(number Rsp)"
test "$(number detector_1)" = "$(number Rsp)" -a "$(number detector_d)" = 0.0 || complain "detectors of the lit fibre: $(cat "$work/out")"

# A beam that is stopped in part: check says how much, and the packets go into A_face.
scene part 'beam rectangle 0.2 0.2' 'face rectangle 0.1 0.2 0.5 at=0.05,0' ""
expect_code 0 check "$work/part.mci"
grep -q 'faces and ports stop 50 % of beam 1, and count it in A_face' "$work/err" || complain "check: $(cat "$work/err")"
expect_error 2 "$work/none.mci:5: beam = nothing of it passes boundary 0 (expected light that the open plane lets in; light of a fibre starts in its port: write beam port NAME)" \
    check "$(scene none 'beam disk 0.05' 'face disk 0.3 0.5\nport disk 0.05 n=1.5' ''; echo "$work/none.mci")"
expect_error 2 "$work/bare.mci:10: beam = nothing of it passes boundary 0 (expected light that the open plane lets in; light of a fibre starts in its port: write beam port NAME)" \
    check "$(scene bare '' 'port disk 0.05 n=1.5 at=1,0\nface disk 0.3 0.5' ''; echo "$work/bare.mci")" # the default pencil has no line: that of the face
scene glow 'beam port 1 light=na:0.5' 'face 0.5 lambertian\nport disk 0.01 n=1.5' ""
sed -i 's/1.4 0.5 50/1.4 0 0/' "$work/glow.mci"
expect_code 0 check "$work/glow.mci"
grep -q 'glow.mci:10: a lambertian face over layer 1, which is clear' "$work/err" || complain "check: $(cat "$work/err")"

# Walls of R = 1 without a way out: later faces cover the port and the black face, whole or not.
scene sealed 'beam pencil z=0.1 light=isotropic' 'face 1\nport disk 0.1 n=1.5\nface ring 0.2 0.3 0\nface disk 0.1 metal 0 3\nface rectangle 0.6 0.6 1' 'backing 1\n'
sed -i 's/1.4 0.5 50/1.4 0 50/' "$work/sealed.mci"
expect_error 2 "$work/sealed.mci:10: face: R = 1 (expected less than 1, a port that no line covers, or a medium that absorbs: over a backing of R = 1 light would never end)" \
    run "$work/sealed.mci" --quiet -o "$work"
sed 's/rectangle 0.6 0.6/rectangle 0.6 0.599/' "$work/sealed.mci" >"$work/rim.mci"
expect_code 0 check "$work/rim.mci"

# Light that a clear layer below a mirror traps: check says from which angle on, and the run counts it. Other faces end all light.
for face in '1 62.4573' '0.5' '1 lambertian'; do
    scene clear 'beam pencil z=0.1 light=isotropic' "face ${face% 6*}" ""
    sed -i -e 's/1.4 0.5 50/1.5 0 0/' -e 's/^1\.0$/1.6/' -e '$s/.*/1.33/' "$work/clear.mci"
    sed -i '1s/.*/1.0/' "$work/clear.mci"
    expect_code 0 check "$work/clear.mci"
    if test "$face" = '1 62.4573'; then
        grep -q 'larger n than what is below its mirror: .*, beyond 62.4573 degrees' "$work/err" || complain "check: $(cat "$work/err")"
    else
        ! grep -q 'trapped' "$work/err" || complain "face $face, check: $(cat "$work/err")"
    fi
    expect_code 0 run "$work/clear.mci" --quiet --json -o "$work"
    awk -v found="$(number trapped)" -v face="$face" 'BEGIN { share = face ~ /^1 6/ ? sqrt(1 - (1.33 / 1.5) ^ 2) : 0; exit !((found / 4000 - share) ^ 2 < 1e-6) }' ||
        complain "face $face: $(number trapped) packets trapped"
done

# Adding-doubling, the furnace and devices refuse boundary 0 with a face.
for call in "exact" "furnace" "run --engine opencl --quiet -o $work"; do
    expect_code 2 ${call%% *} "$work/probe.mci" $(echo "$call" | cut -s -d' ' -f2-)
    grep -q 'boundary 0 has a face' "$work/err" || complain "$call: $(cat "$work/err")"
done

# Settings, by kind and number; names that a port's beam does not have.
expect_code 0 check "$work/probe.mci" --json --set face.r=0.1 --set port2.radius=0.005 --set port3.r2=0.06 --set port1.n=1.3
for text in '"r":0.1' '"size":\[0.005[^]]*\]' '"size":\[0.02[^,]*,0.0[56]9*' '"n":1.3'; do
    grep -q "$text" "$work/out" || complain "--set: no $text in $(cat "$work/out")"
done
expect_code 2 check "$work/probe.mci" --set beam.x=1
grep -q 'beam with .angle .azimuth .na, .*face with .r .x .y .radius, port1..2 with .n .x .y .radius, port3 with .n .x .y .r1 .r2' "$work/err" ||
    complain "names: $(cat "$work/err")"
printf 'face.r,port3.n\n0.6,1.5\n0.1,1.4\n' >"$work/table.csv"
mkdir "$work/rows"
expect_code 0 "$work/probe.mci" --sweep "$work/table.csv" -o "$work/rows" --quiet
head -1 "$work/rows/probe.sweep.csv" | grep -q 'Tt,Tt_se,A_face,A_face_se,layer1.A' || complain "columns: $(head -1 "$work/rows/probe.sweep.csv")"
awk -F, 'NR == 1 { for (i = 1; i <= NF; i++) if ($i == "A_face") at = i } NR > 1 { face[NR] = $at } END { exit !(face[3] > 1.2 * face[2] && face[2] > 0) }' \
    "$work/rows/probe.sweep.csv" || complain "A_face of rows: $(cat "$work/rows/probe.sweep.csv")"

# trace names what a packet meets; other lines are as ever.
expect_code 0 trace "$work/probe.mci" 3
grep -q '^# through port in$' "$work/out" || complain "trace: $(head -20 "$work/out")"
for photon in 0 1 2 3 4 5 6 7; do "$program" trace "$work/part.mci" $photon 2>&1; done >"$work/out"
grep -q '^# stopped by face 1$' "$work/out" || complain "trace: nothing is stopped in $(cat "$work/out")"
for photon in 0 1 2 3 4 5 6 7; do "$program" trace "$work/probe.mci" $photon 2>&1; done >"$work/out"
grep -q '^# face 1$' "$work/out" || complain "trace: no packet meets the face"

# Parts of other faces are another run, and files of other faces are not merged.
expect_code 0 run "$work/probe.mci" --quiet --part 1/2 -o "$work"
cp "$work/probe.mci" "$work/kept.mci"
sed -i 's/face disk 0.3 0.6/face disk 0.3 0.7/' "$work/probe.mci"
expect_code 0 run "$work/probe.mci" --quiet --part 2/2 -o "$work"
expect_code 2 merge "$work"/probe.mco.part?of2
grep -q 'another' "$work/err" || complain "merge of other faces: $(cat "$work/err")"
finish

# Two panels from a result of speed.py: time per step against the number of primitives, and the ratio to original MCML.
# Called by speed.py with work (a folder of series), out, kind (svg or pngcairo) and bars (is there a ratio?).
# Colours are Okabe and Ito's; medium also shows as open or filled markers, the kind as their shape, so that no series
# needs its colour.
# SPDX-License-Identifier: MIT
blue = '#0072B2'
red = '#D55E00'
if (kind eq 'svg') {
    set terminal svg size (bars ? 1150 : 680), 480 font 'sans,13' background '#ffffff'
} else {
    set terminal pngcairo size (bars ? 1150 : 680), 480 font 'sans,11'
}
set output out
set border 3
set tics nomirror
set grid ytics lc rgb '#dddddd' lt 1
set bars 0.5
set pointsize 1.1
if (bars) set multiplot layout 1, 2

series(name) = work . '/' . name
set title 'Time per step on one thread'
set xlabel 'rings (cones) or triangles (mesh) of the top'
set ylabel 'ns / step'
set logscale xy
set xrange [7:2e6]
set yrange [3:3000]
set ytics (3, 5, 10, 20, 50, 100, 200, 500)
set format x '10^{%T}'
set key top left Left reverse samplen 3 maxrows 4 width -2
stats series('S2-flat-plane') using 2 nooutput
s2 = STATS_mean
stats series('S6a-flat-plane') using 2 nooutput
s6a = STATS_mean
plot series('S2-rings-mesh') using 1:2:3:4 with yerrorlines pt 8 lw 1.3 lc rgb red title 'S2, rings as mesh', \
    series('S2-rough-mesh') using 1:2:3:4 with yerrorlines pt 4 lw 1.3 lc rgb red title 'S2, rough mesh', \
    series('S2-rings-cone') using 1:2:3:4 with yerrorlines pt 6 lw 1.3 lc rgb red title 'S2, rings as cones', \
    s2 with lines dt 2 lw 2 lc rgb red title 'S2, flat', \
    series('S6a-rings-mesh') using 1:2:3:4 with yerrorlines pt 9 lw 1.3 lc rgb blue title 'S6a, rings as mesh', \
    series('S6a-rough-mesh') using 1:2:3:4 with yerrorlines pt 5 lw 1.3 lc rgb blue title 'S6a, rough mesh', \
    series('S6a-rings-cone') using 1:2:3:4 with yerrorlines pt 7 lw 1.3 lc rgb blue title 'S6a, rings as cones', \
    s6a with lines dt 4 lw 2 lc rgb blue title 'S6a, flat'

if (bars) {
    set title 'Flat scenes on one thread: time of original MCML / ours'
    unset logscale
    unset key
    set xrange [*:*]
    set yrange [0:*]
    set ytics auto
    set xlabel 'scene'
    set ylabel 'ratio of seconds per photon'
    set style fill solid 0.6 noborder
    set boxwidth 0.6
    plot series('mcml') using 0:2:xticlabels(1) with boxes lc rgb blue, \
        series('mcml') using 0:2:3:4 with yerrorbars pt 7 ps 0.3 lw 1.5 lc rgb 'black'
    unset multiplot
}

# One row of three panels per scene from a result of accuracy.sh: bias against time per step, total error against time,
# failures against time per step. Called by accuracy.sh with work (a folder of series), out, kind (svg or pngcairo).
# Colours are Okabe and Ito's; every method has its own marker, too. All scenes have the same axes and one key. What
# lies below an axis is drawn on it.
# SPDX-License-Identifier: MIT
scenes = system('cat ' . work . '/scenes')
width = 1400.
head = 150. # pixels of the key
row = 250.  # of a scene
height = head + row * words(scenes)
if (kind eq 'svg') {
    set terminal svg size width, height font 'sans,12' background '#ffffff'
} else {
    set terminal pngcairo size width, height font 'sans,10'
}
set output out
meshes = 'analytic-area analytic-inscribed vertex-area vertex-inscribed facet-area facet-inscribed'
colours = '#0072B2 #56B4E9 #009E73 #009E73 #D55E00 #E69F00'
shapes = '5 4 7 6 9 8'
curves = 'plane cpu-cone mesh mesh-analytic-area-1e-1 mesh-vertex-area-1e-1 sampled-face-50'
hues = 'black #CC79A7 #0072B2 #56B4E9 #009E73 #D55E00'
names = '"total error: plane" "cones" "mesh, default tolerance" "mesh at 1e-1" "the same, vertex normals" "rough top, 50 x 50"'
file(scene, name) = sprintf('%s/%s.%s', work, scene, name)
colour(i) = word(colours, i)
shape(i) = int(word(shapes, i))
left(column) = (75. + (column - 1) * 465.) / width
above(i) = 1. - (head + (i - 1) * row + 28.) / height

set multiplot
set tics nomirror
unset mxtics
unset mytics
set bars 0.4
set pointsize 0.7
set samples 2
set lmargin at screen 0
set rmargin at screen 1
set bmargin at screen 1 - head / height
set tmargin at screen 1 - 36 / height
set label 1 'What accuracy each representation of a boundary buys for its time' at screen left(1), screen 1 - 18. / height font ',15'
set xrange [0:1]
set yrange [0:1]
unset border
unset tics
set key at screen left(1), screen 1 - 36. / height left top Left reverse samplen 2 width 1 maxrows 6 font ',11'
plot for [k = 1:6] NaN with points pt shape(k) lc rgb colour(k) \
        title 'mesh, ' . word('analytic analytic vertex vertex facet facet', k) . ' normals, ' . word('area-kept inscribed', 2 - k % 2), \
    NaN with points pt 2 lc rgb 'black' title 'plane (shape ignored)', \
    NaN with points pt 13 lc rgb '#CC79A7' title 'cones', \
    NaN with points pt 12 lc rgb '#CC79A7' title 'cones, opencl', \
    NaN with points pt 10 ps 1.4 lw 2 lc rgb '#0072B2' title 'mesh, default tolerance', \
    NaN with points pt 6 ps 2 lw 2 lc rgb 'black' title 'auto', \
    NaN with points pt 1 ps 0.7 lc rgb '#777777' title 'bias of Rd(r) and Tt(r) (L2)', \
    NaN with lines lw 2 lc rgb '#aaaaaa' title 'Pareto front', \
    NaN with lines dt 2 lc rgb 'black' title 'default tolerance', \
    NaN with lines dt 3 lc rgb '#0072B2' title 'bound on paper, the first', \
    for [k = 1:6] NaN with lines lw 2 lc rgb word(hues, k) title word(names, k), \
    NaN with points pt 7 ps 1 lc rgb 'black' title 'knee: noise equals bias'
unset label 1
set key off
set border 3
set logscale xy
set grid lc rgb '#dddddd' lt 1

do for [i = 1:words(scenes)] {
    scene = word(scenes, i)
    set tmargin at screen above(i)
    set bmargin at screen above(i) - (row - 78) / height
    set lmargin at screen left(1)
    set rmargin at screen left(1) + 370 / width
    set xlabel 'ns / step' offset 0, 0.6
    set xrange [10:2000]
    set xtics nomirror (10, 20, 50, 100, 200, 500, 1000, 2000)
    set yrange [1e-8:1]
    set format y '10^{%T}'
    set ytics nomirror 1e-8, 100, 1
    set ylabel 'worst bias of Rd, A, Tt'
    set title scene . ': relative bias (bars: 2 s.e.)' offset 0, -0.6
    plot file(scene, 'front') using 1:2 with steps lw 2 lc rgb '#aaaaaa', \
        1e-3 with lines dt 2 lc rgb 'black', \
        file(scene, 'mesh-analytic-area') using 1:6 with lines dt 3 lc rgb '#0072B2', \
        for [k = 1:6] file(scene, 'mesh-' . word(meshes, k)) using 1:4 with points pt 1 ps 0.6 lc rgb colour(k), \
        file(scene, 'cone') using 1:4 with points pt 1 ps 0.6 lc rgb '#CC79A7', \
        file(scene, 'plane') using 1:4 with points pt 1 ps 0.6 lc rgb 'black', \
        file(scene, 'auto') using 1:2:3 with yerrorbars pt 6 ps 2 lw 2 lc rgb 'black', \
        for [k = 1:6] file(scene, 'mesh-' . word(meshes, k)) using 1:2:3 with yerrorbars pt shape(k) lc rgb colour(k), \
        file(scene, 'mesh-auto') using 1:2:3 with yerrorbars pt 10 ps 1.4 lw 2 lc rgb '#0072B2', \
        file(scene, 'cone') using 1:2:3 with yerrorbars pt 13 lc rgb '#CC79A7', \
        file(scene, 'opencl') using 1:2:3 with yerrorbars pt 12 lc rgb '#CC79A7', \
        file(scene, 'plane') using 1:2:3 with yerrorbars pt 2 lc rgb 'black'
    set lmargin at screen left(2)
    set rmargin at screen left(2) + 370 / width
    set xrange [1e-5:1e3]
    set yrange [1e-5:10]
    set format x '10^{%T}'
    set xtics nomirror 1e-5, 100, 1e3
    set ytics nomirror 1e-5, 100, 10
    set xlabel 'processor seconds'
    set ylabel 'relative error'
    set title scene . ': total error, sqrt(bias^2 + s^2/(r t))'
    plot for [k = 1:words(curves)] file(scene, 'curve.' . word(curves, k)) with lines lw 2 lc rgb word(hues, k), \
        file(scene, 'knees') with points pt 7 ps 0.9 lc rgb 'black'
    set lmargin at screen left(3)
    set rmargin at screen left(3) + 370 / width
    set xrange [10:2000]
    set yrange [1:1e6]
    set format x '%g'
    set xtics nomirror (10, 20, 50, 100, 200, 500, 1000, 2000)
    set ytics nomirror 1, 100, 1e6
    set xlabel 'ns / step'
    set ylabel 'lost per 1e9 crossings'
    set title scene . ': failures (with tail: none seen, 95 % limit)'
    plot for [k = 1:6] file(scene, 'mesh-' . word(meshes, k)) using 1:5 with points pt shape(k) lc rgb colour(k), \
        file(scene, 'mesh-auto') using 1:5 with points pt 10 ps 1.4 lw 2 lc rgb '#0072B2', \
        file(scene, 'cone') using 1:5 with points pt 13 lc rgb '#CC79A7', \
        file(scene, 'opencl') using 1:5 with points pt 12 lc rgb '#CC79A7', \
        file(scene, 'plane') using 1:5 with points pt 2 lc rgb 'black', \
        file(scene, 'auto') using 1:5 with points pt 6 ps 2 lw 2 lc rgb 'black', \
        file(scene, 'limits') using 1:2:(0):(-0.6 * $2) with vectors nohead lw 1.5 lc rgb '#aaaaaa'
}
unset multiplot

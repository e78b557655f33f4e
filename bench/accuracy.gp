# One row of four panels per scene from a result of accuracy.sh: bias of totals and of the profile against time per step,
# total error against time, failures against time per step. Called by accuracy.sh with work (a folder of series), out.
# Colours are Okabe and Ito's; every method has its own marker, too. Points on the lower edge are limits, not values.
# SPDX-License-Identifier: MIT
scenes = system('cat ' . work . '/scenes')
set terminal svg size 1500, 330 * words(scenes) font 'sans,12' background '#ffffff'
set output out
set border 3
set tics nomirror
unset mxtics
unset mytics
set grid lc rgb '#dddddd' lt 1
set bars 0.4
set pointsize 0.9
set logscale xy
set format y '10^{%T}'
set lmargin 11
meshes = 'analytic-area analytic-inscribed vertex-area vertex-inscribed facet-area facet-inscribed'
colours = '#0072B2 #56B4E9 #009E73 #66C2A5 #D55E00 #E69F00'
shapes = '5 4 7 6 9 8'
file(scene, name) = sprintf('%s/%s.%s', work, scene, name)
colour(i) = word(colours, i)
shape(i) = int(word(shapes, i))

set multiplot layout words(scenes), 4
do for [i = 1:words(scenes)] {
    scene = word(scenes, i)
    set key off
    set xlabel 'ns / step'
    set format x '%g'
    set xrange [10:5000]
    set yrange [1e-6:1]
    set ylabel 'worst |relative bias| of Rd, A, Tt'
    set title scene . ': totals (bars: 2 s.e.)'
    plot file(scene, 'front') using 1:2 with steps lw 2 lc rgb '#bbbbbb', \
        1e-3 with lines dt 2 lc rgb 'black', \
        for [k = 1:6] file(scene, 'mesh-' . word(meshes, k)) using 1:2:3 with yerrorbars pt shape(k) lc rgb colour(k), \
        file(scene, 'mesh-analytic-area') using 1:6 with lines dt 3 lc rgb '#0072B2', \
        file(scene, 'mesh-auto') using 1:2 with points pt 10 ps 1.6 lw 2 lc rgb '#0072B2', \
        file(scene, 'cone') using 1:2:3 with yerrorbars pt 13 lc rgb '#CC79A7', \
        file(scene, 'opencl') using 1:2:3 with yerrorbars pt 12 lc rgb '#CC79A7', \
        file(scene, 'plane') using 1:2:3 with yerrorbars pt 2 lc rgb 'black', \
        file(scene, 'auto') using 1:2 with points pt 6 ps 2.2 lw 2 lc rgb 'black'
    set ylabel 'relative L2 bias of Rd(r), Tt(r)'
    set title scene . ': profile'
    plot 1e-3 with lines dt 2 lc rgb 'black', \
        for [k = 1:6] file(scene, 'mesh-' . word(meshes, k)) using 1:4 with points pt shape(k) lc rgb colour(k), \
        file(scene, 'mesh-auto') using 1:4 with points pt 10 ps 1.6 lw 2 lc rgb '#0072B2', \
        file(scene, 'cone') using 1:4 with points pt 13 lc rgb '#CC79A7', \
        file(scene, 'opencl') using 1:4 with points pt 12 lc rgb '#CC79A7', \
        file(scene, 'plane') using 1:4 with points pt 2 lc rgb 'black', \
        file(scene, 'auto') using 1:4 with points pt 6 ps 2.2 lw 2 lc rgb 'black'
    set key inside right top samplen 2 font ',9'
    set xrange [1e-3:1e3]
    set yrange [1e-6:10]
    set format x '10^{%T}'
    set xlabel 'processor seconds'
    set ylabel 'relative error'
    set title scene . ': error against time, knees'
    plot file(scene, 'curve.cpu-cone') with lines lw 2 lc rgb '#CC79A7' title 'cones', \
        file(scene, 'curve.plane') with lines lw 2 dt 4 lc rgb 'black' title 'plane', \
        file(scene, 'curve.mesh-analytic-area-1e-1') with lines lw 2 dt 2 lc rgb '#56B4E9' title 'mesh, 0.1', \
        file(scene, 'curve.mesh') with lines lw 2 dt 5 lc rgb '#0072B2' title 'mesh, 0.001', \
        file(scene, 'knees') with points pt 7 lc rgb 'black' title 'knee'
    set key inside right bottom maxrows 7 samplen 1 font ',9'
    set xrange [10:5000]
    set yrange [1e-3:1e7]
    set format x '%g'
    set xlabel 'ns / step'
    set ylabel 'lost per 1e9 crossings (<)'
    set title scene . ': failures, or 95 % limits'
    plot for [k = 1:6] file(scene, 'mesh-' . word(meshes, k)) using 1:5 with points pt shape(k) lc rgb colour(k) title word(meshes, k), \
        file(scene, 'mesh-auto') using 1:5 with points pt 10 ps 1.6 lw 2 lc rgb '#0072B2' title 'mesh, 0.001', \
        file(scene, 'cone') using 1:5 with points pt 13 lc rgb '#CC79A7' title 'cones', \
        file(scene, 'opencl') using 1:5 with points pt 12 lc rgb '#CC79A7' title 'opencl', \
        file(scene, 'plane') using 1:5 with points pt 2 lc rgb 'black' title 'plane', \
        file(scene, 'auto') using 1:5 with points pt 6 ps 2.2 lw 2 lc rgb 'black' title 'auto', \
        1e20 with lines lw 2 lc rgb '#bbbbbb' title 'Pareto front', \
        1e20 with lines dt 2 lc rgb 'black' title 'tolerance', \
        1e20 with lines dt 3 lc rgb '#0072B2' title 'bound on paper'
}
unset multiplot

# A page of one scene from a result of accuracy.py: bias against time per step, total error against time, failures against time
# per step, and a key of what the scene has. Drawn by it with work (a folder of series), scene and out. To be read at 18 cm
# of width, where its letters have 9 pt. Colours are Okabe and Ito's; every method has its own marker, too. All scenes have the
# same axes but for the time per step. What lies below an axis is drawn on it.
# SPDX-License-Identifier: MIT
width = 680.
height = 652.
set terminal svg size width, height font 'sans,12' background '#ffffff'
set output out
meshes = 'analytic-area analytic-inscribed vertex-area vertex-inscribed facet-area facet-inscribed'
colours = '#0072B2 #56B4E9 #009E73 #009E73 #D55E00 #E69F00'
shapes = '5 4 7 6 9 8'
curves = 'plane cpu-cone mesh mesh-analytic-area-1e-1 mesh-vertex-area-1e-1 sampled-face-50'
hues = 'black #CC79A7 #0072B2 #0072B2 #009E73 #D55E00'
dashes = '1 1 1 2 1 1'
names = '"plane" "cones" "mesh, default tolerance" "mesh, tolerance 0.1" "the same, vertex normals" "mesh of 50 facets"'
drawn = ' ' . system('cat ' . work . '/' . scene . '.drawn') . ' '
named(series, title) = strstrt(drawn, ' ' . series . ' ') ? title : ''
radial = strlen(named('curve.cpu-cone', 'yes')) # else the surface is a mesh, of which coarser ones are samples
file(name) = sprintf('%s/%s.%s', work, scene, name)
mesh(i) = 'mesh-' . word(meshes, i)
colour(i) = word(colours, i)
shape(i) = int(word(shapes, i))
place(x, y) = sprintf('set lmargin at screen %f; set rmargin at screen %f; set tmargin at screen %f; set bmargin at screen %f', \
    x / width, (x + 258) / width, 1 - y / height, 1 - (y + 214) / height) # of a panel, from the page's upper left corner

set multiplot
set tics nomirror
unset mxtics
unset mytics
set bars 0.4
set pointsize 0.7
set samples 2
set border 3
set logscale xy
set grid lc rgb '#dddddd' lt 1
set key off
set label 1 scene . ': the accuracy that each way to fly it buys for its time' at screen 10 / width, screen 1 - 20 / height font ',15'

eval place(68., 62.)
set xlabel 'ns per step' offset 0, 0.4
times = system('cat ' . work . '/' . scene . '.times')
set xrange [word(times, 1) + 0.:word(times, 2) + 0.]
if (word(times, 2) / word(times, 1) > 100) {
    set xtics (1, 3, 10, 30, 100, 300, 1000, 3000, 10000)
} else {
    set xtics (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000)
}
set yrange [1e-8:1]
set format y '10^{%T}'
set ytics 1e-8, 100, 1
set ylabel 'worst bias of Rd, A, Tt'
set title 'relative bias (bars: 2 s.e.)' offset 0, -0.6
plot file('front') using 1:2 with steps lw 2 lc rgb '#aaaaaa', \
    1e-3 with lines dt 2 lc rgb 'black', \
    file('mesh-analytic-area') using 1:6 with lines dt 3 lc rgb '#0072B2', \
    for [k = 1:6] file(mesh(k)) using 1:4 with points pt 1 ps 0.6 lc rgb colour(k), \
    file('cone') using 1:4 with points pt 1 ps 0.6 lc rgb '#CC79A7', \
    file('plane') using 1:4 with points pt 1 ps 0.6 lc rgb 'black', \
    file('auto') using 1:2:3 with yerrorbars pt 6 ps 2 lw 1.2 lc rgb 'black', \
    for [k = 1:6] file(mesh(k)) using 1:2:3 with yerrorbars pt shape(k) lc rgb colour(k), \
    file('mesh-auto') using 1:2:3 with yerrorbars pt 10 ps 1.4 lw 2 lc rgb '#0072B2', \
    file('cone') using 1:2:3 with yerrorbars pt 13 lc rgb '#CC79A7', \
    file('opencl') using 1:2:3 with yerrorbars pt 12 lc rgb '#CC79A7', \
    file('plane') using 1:2:3 with yerrorbars pt 2 lc rgb 'black'
unset label

eval place(68., 364.)
set yrange [1:1e6]
set ytics 1, 100, 1e6
set ylabel 'lost per billion crossings'
set title 'failures (with tail: none seen, 95 % limit)'
plot for [k = 1:6] file(mesh(k)) using 1:5 with points pt shape(k) lc rgb colour(k), \
    file('mesh-auto') using 1:5 with points pt 10 ps 1.4 lw 2 lc rgb '#0072B2', \
    file('cone') using 1:5 with points pt 13 lc rgb '#CC79A7', \
    file('opencl') using 1:5 with points pt 12 lc rgb '#CC79A7', \
    file('plane') using 1:5 with points pt 2 lc rgb 'black', \
    file('auto') using 1:5 with points pt 6 ps 2 lw 1.2 lc rgb 'black', \
    file('limits') using 1:2:(0):(-0.6 * $2) with vectors nohead lw 1.5 lc rgb '#aaaaaa'

eval place(406., 62.)
set xrange [1e-5:1e3]
set yrange [1e-5:10]
set format x '10^{%T}'
set xtics 1e-5, 100, 1e3
set ytics 1e-5, 100, 10
set xlabel 'processor seconds'
set ylabel 'relative error'
set title 'total error: noise and bias'
plot for [k = 1:words(curves)] file('curve.' . word(curves, k)) with lines lw 2 dt int(word(dashes, k)) lc rgb word(hues, k), \
    file('knees') with points pt 7 ps 0.9 lc rgb 'black'

unset title
unset xlabel
unset ylabel
unset border
unset tics
unset grid
unset logscale
set xrange [0:1]
set yrange [0:1]
set lmargin at screen 0
set rmargin at screen 1
set tmargin at screen 1
set bmargin at screen 0 # as high as the page, for the key's rows
set key at screen 350 / width, screen 1 - 330 / height left top Left reverse samplen 2 width 1 maxrows 24 spacing 0.84
plot for [k = 1:6] NaN with points pt shape(k) lc rgb colour(k) title named(mesh(k), 'mesh, ' . \
        word('analytic analytic vertex vertex facet facet', k) . ' normals' . (!radial ? '' : k % 2 ? ', area-kept' : ', inscribed')), \
    NaN with points pt 2 lc rgb 'black' title named('plane', 'plane (shape ignored)'), \
    NaN with points pt 13 lc rgb '#CC79A7' title named('cone', radial ? 'cones' : 'mesh of 40000 facets'), \
    NaN with points pt 12 lc rgb '#CC79A7' title named('opencl', 'cones, opencl'), \
    NaN with points pt 10 ps 1.4 lw 2 lc rgb '#0072B2' title named('mesh-auto', 'mesh, default tolerance'), \
    NaN with points pt 6 ps 1.6 lw 1.2 lc rgb 'black' title named('auto', 'auto'), \
    NaN with points pt 1 ps 0.7 lc rgb '#777777' title 'bias of Rd(r) and Tt(r) (L2)', \
    NaN with lines lw 2 lc rgb '#aaaaaa' title 'Pareto front', \
    NaN with lines dt 2 lc rgb 'black' title 'default tolerance', \
    NaN with lines dt 3 lc rgb '#0072B2' title named('paper', 'optical depths on paper'), \
    for [k = 1:6] NaN with lines lw 2 dt int(word(dashes, k)) lc rgb word(hues, k) \
        title named('curve.' . word(curves, k), 'total error: ' . word(names, k)), \
    NaN with points pt 7 ps 0.9 lc rgb 'black' title named('knees', 'knee: noise equals bias')
unset multiplot

# A panel per scene from a result of frontier.py: bias against the seconds that an error of 0.1 % (large mark) and of 0.01 %
# (small mark) takes. Called by frontier.py with work (a folder of series), out, kind (svg or pngcairo). Colours are Okabe and Ito's; every
# method has its own marker. All panels have the same axes and one key.
# SPDX-License-Identifier: MIT
scenes = system('cat ' . work . '/scenes')
note = system('cat ' . work . '/note')
label(i) = system(sprintf("sed -n %dp %s/labels", i, work))
columns = 3
rows = (words(scenes) + columns) / columns # one place for the key
width = 1320.
head = 56.
row = 300.
height = head + rows * row
if (kind eq 'svg') {
    set terminal svg size width, height font 'sans,12' background '#ffffff'
} else {
    set terminal pngcairo size width, height font 'sans,10'
}
set output out
methods = 'plane cone grid mesh auto'
marks = '2 13 5 8 6'
sizes = '1.0 1.2 0.8 1.1 1.9'
variants = 'before mcml after'
hues = '#E69F00 black #0072B2'
apart = '1.3 1 0.77' # so that none hides another
file(scene, variant, method) = sprintf('%s/%s.%s.%s', work, scene, variant, method)
left(i) = (75. + ((i - 1) % columns) * 430.) / width
above(i) = 1. - (head + int((i - 1) / columns) * row + 22.) / height

set multiplot
set tics nomirror
unset mxtics
unset mytics
set label 1 'How long an error takes, and how far the answer is off' at screen left(1), screen 1 - 20. / height font ',15'
set label 2 'one thread; the slowest and the most biased of Rd, A, Tt above 1 % of the light. Large mark: seconds to a standard error of 0.1 %, small mark: of 0.01 %' . (strlen(note) ? '. ' . note : '') at screen left(1), screen 1 - 40. / height font ',11'
set border 3
set logscale xy
set xrange [1e-2:1e4]
set yrange [1e-7:1]
set format x '10^{%T}'
set format y '10^{%T}'
set xtics 1e-2, 10, 1e4
set ytics 1e-7, 10, 1
set grid lc rgb '#eeeeee' lt 1
set key off
do for [i = 1:words(scenes)] {
    scene = word(scenes, i)
    if (i == 2) {
        unset label
    }
    set lmargin at screen left(i)
    set rmargin at screen left(i) + 345. / width
    set tmargin at screen above(i)
    set bmargin at screen above(i) - (row - 72.) / height
    set title label(i) offset 0, -0.6
    set xlabel 'processor seconds' offset 0, 0.6
    set ylabel 'relative bias' offset 1.5, 0
    plot 1e-3 with lines dt 2 lc rgb '#888888', 1e-4 with lines dt 3 lc rgb '#888888', \
        for [v = 1:3] for [m = 1:5] file(scene, word(variants, v), word(methods, m)) \
            using 1:($3 * real(word(apart, v))):($2 - $1):(0) with vectors nohead lw 1.5 lc rgb word(hues, v), \
        for [v = 1:3] for [m = 1:5] file(scene, word(variants, v), word(methods, m)) \
            using 1:($4 == 1 ? $3 * real(word(apart, v)) : NaN):(0):(-0.5 * $3) with vectors head size screen 0.004,20 lw 1 lc rgb word(hues, v), \
        for [v = 1:3] for [m = 1:5] file(scene, word(variants, v), word(methods, m)) \
            using 1:($3 * real(word(apart, v))) with points pt int(word(marks, m)) ps real(word(sizes, m)) lw 1.5 lc rgb word(hues, v), \
        for [v = 1:3] for [m = 1:5] file(scene, word(variants, v), word(methods, m)) \
            using 2:($3 * real(word(apart, v))) with points pt int(word(marks, m)) ps 0.7 * real(word(sizes, m)) lc rgb word(hues, v)
}
i = words(scenes) + 1
unset title
unset xlabel
unset ylabel
unset border
unset tics
unset grid
unset logscale
set xrange [0:1]
set yrange [0:1]
set lmargin at screen left(i)
set rmargin at screen left(i) + 345. / width
set tmargin at screen above(i)
set bmargin at screen above(i) - (row - 72.) / height
set key at screen left(i), screen above(i) left top Left reverse samplen 2 font ',11' maxrows 14
plot NaN with lines lw 3 lc rgb '#0072B2' title 'after: lattice, roulette window (defaults)', \
    NaN with lines lw 3 lc rgb '#E69F00' title 'before: random, roulette of MCML', \
    NaN with lines lw 3 lc rgb 'black' title 'original MCML, which flies the plane', \
    NaN with points pt 2 lw 1.5 lc rgb '#777777' title 'plane (shape ignored)', \
    NaN with points pt 13 ps 1.2 lc rgb '#777777' title 'cones', \
    NaN with points pt 5 ps 0.8 lc rgb '#777777' title 'mesh on a regular grid, walked', \
    NaN with points pt 8 ps 1.1 lw 1.5 lc rgb '#777777' title 'mesh, searched by Embree', \
    NaN with points pt 6 ps 1.9 lw 1.5 lc rgb '#777777' title 'what auto takes', \
    NaN with vectors head size screen 0.004,20 lc rgb '#777777' title 'no bias seen: drawn at 2 standard errors', \
    NaN with lines dt 2 lc rgb '#888888' title 'bias of 0.1 %', \
    NaN with lines dt 3 lc rgb '#888888' title 'bias of 0.01 %'
unset multiplot

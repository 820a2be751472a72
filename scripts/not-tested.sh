#!/bin/sh
# Names the tests that `make test` left out, or that passed without testing anything as a tool is missing: its last lines.
set -eu

if [ -z "${ETENDUE_NIGHTLY:-}" ]; then
    echo "not tested: whether tests find the planted bugs (make mutants)"
    echo "not tested: fifteen in sixteen cases of the battery with the backends obvhs-bvh2 and obvhs-cwbvh, and those of Markov chains with any (make nightly)"
    echo "not tested: moving objects, alpha and lamps of instances on two of three backends in each case; the mean of adaptive renders with two of three samplers; half of the samples of most comparisons of estimators; whether greedy sampling is biased; error bars and errors asked for in rooms, with the independent sampler, and error bars of rough metal and of caustics at 256 samples per pixel, only at 64; two thirds of the scenes by each integrator of the course, and three quarters of their samples; half of the six scenes by bdpt, mlt and light paths, and two of them by shared paths; half of the kinds of light by bdpt and light paths, and two thirds by shared paths; half of the numbers of bounces by the course, light paths and shared paths, and of the shares of light paths; groups of four pixels that share paths, in most cases; tiny lenses on two of three backends; a third of the moving shadows; three fifths of the arbitrary calls of the C library; half of the errors asked for; error bars of closed forms at 512 samples per pixel; half of the adaptive renders to an error, and most seeds of recommendations (make nightly)"
    echo "not tested: error bars of Markov chains of 8192 steps a pixel, only of 64 and 256; seven in eight of the million paths whose weights are recomputed (make nightly)"
fi

left_out() {
    echo "not tested: $1, as $2 is missing"
}

command -v cbindgen >/dev/null || left_out "whether capi/include/etendue.h is that of the sources" "cbindgen (cargo install cbindgen)"
command -v python3 >/dev/null || left_out "examples/python" "python3"
echo 'int main(void) { return 0; }' | cc -fsanitize=address -x c - -o /dev/null 2>/dev/null ||
    left_out "clients with AddressSanitizer" "a C compiler with it"
[ "$(id -u)" = 0 ] || left_out "checkpoints on a full disk" "root"
command -v sbatch >/dev/null || left_out "job arrays, by make slurm" "slurm-wlm"
[ -n "${OIDN_DIR:-}" ] || /sbin/ldconfig -p 2>/dev/null | grep -qE 'libOpenImageDenoise\.so(\.2)? ' || left_out "renders filtered by it" "Open Image Denoise"

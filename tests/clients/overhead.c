/* What a call costs: prints the least and the median time of a picture of 1 x 1 pixel by 1 sample, scene already built, from
 * etd_render_create to etd_render_release; and of a camera that replaces another. */

#include "small_scene.h"
#include <time.h>

enum { TIMES = 501 };

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static int by_size(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void print(const char *what, double *seconds) {
    qsort(seconds, TIMES, sizeof *seconds, by_size);
    printf("%s: %.3f ms at least, %.3f ms in the median\n", what, 1e3 * seconds[0],
           1e3 * seconds[TIMES / 2]);
}

int main(void) {
    static double renders[TIMES], cameras[TIMES];
    EtdScene *scene = make_scene(1, 1);
    DONE(scene, etd_scene_commit(scene, NULL));
    EtdSettings settings;
    memset(&settings, 0, sizeof settings);
    settings.struct_size = sizeof settings;
    settings.spp = 1;
    EtdCamera camera;
    memset(&camera, 0, sizeof camera);
    camera.struct_size = sizeof camera;
    camera.eye[2] = 6.0;
    for (int i = 0; i < TIMES; i++) {
        float pixel[3];
        EtdRender *render = NULL;
        double start = now();
        DONE(scene, etd_render_create(scene, &settings, &render));
        CHECK(etd_render_run(render, NULL) == ETD_STATUS_OK);
        CHECK(etd_render_read_pixels(render, pixel, sizeof pixel, 0, 0) == ETD_STATUS_OK);
        CHECK(etd_render_release(render) == ETD_STATUS_OK);
        renders[i] = now() - start;
        camera.eye[1] = 0.001 * i;
        start = now();
        DONE(scene, etd_scene_set_camera(scene, &camera));
        cameras[i] = now() - start;
    }
    print("1 x 1 pixel, 1 sample", renders);
    print("another camera", cameras);
    EtdWork work;
    work.struct_size = sizeof work;
    DONE(scene, etd_scene_work(scene, &work));
    CHECK(work.builds == 1 && work.cameras == TIMES);
    CHECK(etd_scene_release(scene) == ETD_STATUS_OK);
    return 0;
}

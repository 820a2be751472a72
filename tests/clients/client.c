/* A client in C: client (SCENE OUT.pfm)... renders each scene to its file, and tries everything else on a scene in memory. */

#include "small_scene.h"
#include <math.h>
#include <pthread.h>

enum { WIDTH = 24, HEIGHT = 16 };

static EtdSettings settings_of(uint64_t spp) {
    EtdSettings settings;
    memset(&settings, 0, sizeof settings);
    settings.struct_size = sizeof settings;
    settings.spp = spp;
    return settings;
}

static EtdRender *begin(EtdScene *scene, const EtdSettings *settings) {
    EtdRender *render = NULL;
    DONE(scene, etd_render_create(scene, settings, &render));
    return render;
}

static EtdRenderInfo info_of(const EtdRender *render) {
    EtdRenderInfo info;
    memset(&info, 0, sizeof info);
    info.struct_size = sizeof info;
    CHECK(etd_render_info(render, &info) == ETD_STATUS_OK);
    return info;
}

static void read_all(const EtdRender *render, float *pixels) {
    const size_t size = WIDTH * HEIGHT * 3 * sizeof *pixels;
    CHECK(etd_render_read_pixels(render, pixels, size, 0, 0) == ETD_STATUS_OK);
}

/* The scene of a file, as the command renders it. */
static void a_file(const char *path, const char *out) {
    EtdScene *scene = NULL;
    CHECK(etd_scene_create(&scene) == ETD_STATUS_OK);
    DONE(scene, etd_scene_load(scene, path));
    DONE(scene, etd_scene_commit(scene, NULL));
    EtdSettings settings = settings_of(4);
    settings.flags = ETD_HAS_SEED;
    settings.seed = 7;
    settings.sampler = "independent";
    settings.light_paths = "off";
    settings.filter_sampling = "splatting";
    EtdRender *render = begin(scene, &settings);
    /* The render keeps the scene. */
    CHECK(etd_scene_release(scene) == ETD_STATUS_OK);
    CHECK(etd_render_run(render, NULL) == ETD_STATUS_OK);
    CHECK(etd_render_write(render, out) == ETD_STATUS_OK);
    CHECK(etd_render_release(render) == ETD_STATUS_OK);
}

struct watched {
    pthread_mutex_t lock;
    unsigned progress, pictures;
    uint64_t samples;
    double last_fraction;
    float middle;
    unsigned end_after;
    EtdRender *render;
    EtdScene *scene;
    EtdStatus inside;
};

static int32_t on_progress(void *user, const EtdProgress *progress) {
    struct watched *watched = user;
    pthread_mutex_lock(&watched->lock);
    watched->progress++;
    if (progress->samples > watched->samples) {
        watched->samples = progress->samples;
        watched->last_fraction = progress->fraction;
    }
    const int ends = watched->end_after != 0 && watched->progress >= watched->end_after;
    if (watched->render) {
        float pixel[3];
        watched->inside = etd_render_read_pixels(watched->render, pixel, sizeof pixel, 0, 0);
    }
    pthread_mutex_unlock(&watched->lock);
    return ends;
}

static void on_picture(void *user, const EtdPicture *picture) {
    struct watched *watched = user;
    CHECK(picture->width == WIDTH && picture->height == HEIGHT);
    watched->pictures++;
    watched->middle = picture->rgb[3 * (WIDTH * (HEIGHT / 2) + WIDTH / 2)];
    if (watched->scene) {
        /* Nobody changes a scene that is being rendered. */
        EtdFilm film;
        memset(&film, 0, sizeof film);
        film.struct_size = sizeof film;
        film.width = film.height = 8;
        CHECK(etd_scene_set_film(watched->scene, &film) == ETD_STATUS_BUSY);
    }
}

static struct watched watched_by(EtdWatch *watch) {
    struct watched watched;
    memset(&watched, 0, sizeof watched);
    memset(watch, 0, sizeof *watch);
    watch->struct_size = sizeof *watch;
    watch->progress = on_progress;
    watch->picture = on_picture;
    return watched;
}

/* Renders with somebody watching, reads everything, and goes on. */
static void pictures(void) {
    EtdScene *scene = make_scene(WIDTH, HEIGHT);
    EtdSettings settings = settings_of(16);
    settings.flags = ETD_LAYERS;
    EtdRender *render = NULL;
    CHECK(etd_render_create(scene, &settings, &render) == ETD_STATUS_NOT_COMMITTED);
    CHECK(render == NULL);
    DONE(scene, etd_scene_commit(scene, NULL));
    render = begin(scene, &settings);
    EtdWatch watch;
    struct watched watched = watched_by(&watch);
    pthread_mutex_init(&watched.lock, NULL);
    watched.render = render;
    watched.scene = scene;
    watch.user = &watched;
    CHECK(etd_render_run(render, &watch) == ETD_STATUS_OK);
    CHECK(watched.progress >= 1 && watched.pictures >= 1);
    CHECK(watched.samples == 16 * WIDTH * HEIGHT && watched.last_fraction == 1.0);
    CHECK(watched.inside == ETD_STATUS_BUSY);

    EtdRenderInfo info = info_of(render);
    CHECK(info.width == WIDTH && info.height == HEIGHT && info.spp == 16);
    CHECK(info.samples == 16 * WIDTH * HEIGHT && info.rejected == 0 && !info.cancelled);
    CHECK(info.rel_rmse > 0 && info.rel_rmse < info.rel_rmse_upper && info.rel_rmse_upper < 1);

    static float pixels[HEIGHT][WIDTH][3];
    read_all(render, &pixels[0][0][0]);
    CHECK(pixels[HEIGHT / 2][WIDTH / 2][0] == watched.middle);
    CHECK(fabsf(pixels[0][0][1] - 1.0f) < 1e-5f); /* The sky. */
    CHECK(watched.middle > 0.1f && watched.middle < 0.6f);

    /* As RGBA, in rows that end with a gap; what is between stays. */
    static float rgba[HEIGHT][WIDTH + 1][4];
    for (int i = 0; i < HEIGHT * (WIDTH + 1) * 4; i++) {
        (&rgba[0][0][0])[i] = 42;
    }
    CHECK(etd_render_read_pixels(render, &rgba[0][0][0], sizeof rgba, sizeof rgba[0][0],
                                 sizeof rgba[0]) == ETD_STATUS_OK);
    for (int y = 0; y < HEIGHT; y++) {
        for (int x = 0; x < WIDTH; x++) {
            CHECK(memcmp(rgba[y][x], pixels[y][x], sizeof pixels[y][x]) == 0);
            CHECK(rgba[y][x][3] == 42);
        }
        CHECK(rgba[y][WIDTH][0] == 42);
    }

    static float errors[HEIGHT][WIDTH][3], layer[HEIGHT][WIDTH];
    CHECK(etd_render_read_standard_errors(render, &errors[0][0][0], sizeof errors, 0, 0) ==
          ETD_STATUS_OK);
    CHECK(errors[HEIGHT / 2][WIDTH / 2][0] > 0 && errors[HEIGHT / 2][WIDTH / 2][0] < 0.2f);
    CHECK(etd_render_read_layer(render, "albedo.G", &layer[0][0], sizeof layer, 0, 0) ==
          ETD_STATUS_OK);
    CHECK(fabsf(layer[HEIGHT / 2][WIDTH / 2] - 0.5f) < 1e-5f);
    CHECK(etd_render_read_layer(render, "se.R", &layer[0][0], sizeof layer, 0, 0) ==
          ETD_STATUS_OK);
    CHECK(layer[HEIGHT / 2][WIDTH / 2] == errors[HEIGHT / 2][WIDTH / 2][0]);

    /* 16 samples and 16 more are 32 at once. */
    CHECK(etd_render_add_samples(render, 16, NULL) == ETD_STATUS_OK);
    CHECK(info_of(render).spp == 32);
    static float added[HEIGHT][WIDTH][3];
    read_all(render, &added[0][0][0]);
    settings.spp = 32;
    EtdRender *whole = begin(scene, &settings);
    CHECK(etd_render_run(whole, NULL) == ETD_STATUS_OK);
    read_all(whole, &pixels[0][0][0]);
    CHECK(memcmp(added, pixels, sizeof pixels) == 0);
    CHECK(etd_render_release(whole) == ETD_STATUS_OK);
    CHECK(etd_render_release(render) == ETD_STATUS_OK);
    CHECK(etd_scene_release(scene) == ETD_STATUS_OK);
}

/* An adaptive render may be run again if it is complete, and continues if it was cancelled. */
static void adaptive(void) {
    EtdScene *scene = make_scene(WIDTH, HEIGHT);
    DONE(scene, etd_scene_commit(scene, NULL));
    EtdSettings settings = settings_of(16);
    settings.adaptive = "two-phase";
    EtdRender *render = begin(scene, &settings);
    CHECK(etd_render_run(render, NULL) == ETD_STATUS_OK);
    const uint64_t samples = info_of(render).samples;
    CHECK(etd_render_run(render, NULL) == ETD_STATUS_OK && info_of(render).samples == samples);
    CHECK(etd_render_release(render) == ETD_STATUS_OK);
    render = begin(scene, &settings);
    EtdWatch watch;
    struct watched watched = watched_by(&watch);
    pthread_mutex_init(&watched.lock, NULL);
    watched.end_after = 2;
    watch.user = &watched;
    CHECK(etd_render_run(render, &watch) == ETD_STATUS_CANCELLED);
    CHECK(etd_render_run(render, NULL) == ETD_STATUS_OK && info_of(render).samples == samples);
    CHECK(etd_render_release(render) == ETD_STATUS_OK);
    CHECK(etd_scene_release(scene) == ETD_STATUS_OK);
}

/* Ends while an irradiance cache is filled, before the first sample. */
static int32_t on_cache(void *user, const EtdProgress *progress) {
    *(uint64_t *)user += progress->samples;
    return 1;
}

static void cancelling_a_cache(void) {
    EtdScene *scene = make_scene(WIDTH, HEIGHT);
    DONE(scene, etd_scene_commit(scene, NULL));
    EtdSettings settings = settings_of(4);
    settings.integrator = "irradiance-cache";
    EtdRender *render = begin(scene, &settings);
    EtdWatch watch;
    memset(&watch, 0, sizeof watch);
    watch.struct_size = sizeof watch;
    watch.progress = on_cache;
    uint64_t samples = 0;
    watch.user = &samples;
    CHECK(etd_render_run(render, &watch) == ETD_STATUS_CANCELLED);
    CHECK(samples == 0 && info_of(render).samples == 0);
    CHECK(etd_render_run(render, NULL) == ETD_STATUS_OK && info_of(render).spp == 4);
    CHECK(etd_render_release(render) == ETD_STATUS_OK);
    CHECK(etd_scene_release(scene) == ETD_STATUS_OK);
}

static void *run_long(void *render) {
    static EtdStatus status;
    status = etd_render_run(render, NULL);
    return &status;
}

/* Ends renders from their own functions and from another thread, and goes on. */
static void cancelling(void) {
    EtdScene *scene = make_scene(WIDTH, HEIGHT);
    DONE(scene, etd_scene_commit(scene, NULL));
    EtdSettings settings = settings_of(8);
    EtdRender *render = begin(scene, &settings);
    EtdWatch watch;
    struct watched watched = watched_by(&watch);
    pthread_mutex_init(&watched.lock, NULL);
    watched.end_after = 2;
    watch.user = &watched;
    CHECK(etd_render_run(render, &watch) == ETD_STATUS_CANCELLED);
    CHECK(info_of(render).cancelled && info_of(render).spp < 8);
    CHECK(etd_render_run(render, NULL) == ETD_STATUS_OK);
    CHECK(!info_of(render).cancelled && info_of(render).spp == 8);
    static float resumed[HEIGHT][WIDTH][3], whole[HEIGHT][WIDTH][3];
    read_all(render, &resumed[0][0][0]);
    EtdRender *at_once = begin(scene, &settings);
    CHECK(etd_render_run(at_once, NULL) == ETD_STATUS_OK);
    read_all(at_once, &whole[0][0][0]);
    CHECK(memcmp(resumed, whole, sizeof whole) == 0);
    CHECK(etd_render_release(at_once) == ETD_STATUS_OK);
    CHECK(etd_render_release(render) == ETD_STATUS_OK);

    settings.spp = (uint64_t)1 << 40;
    render = begin(scene, &settings);
    pthread_t thread;
    CHECK(pthread_create(&thread, NULL, run_long, render) == 0);
    /* Whether the run has begun is not known: asked for until it has ended. */
    EtdRenderInfo info;
    memset(&info, 0, sizeof info);
    info.struct_size = sizeof info;
    do {
        CHECK(etd_render_cancel(render) == ETD_STATUS_OK);
    } while (etd_render_info(render, &info) == ETD_STATUS_BUSY || !info.cancelled);
    void *status = NULL;
    CHECK(pthread_join(thread, &status) == 0);
    CHECK(*(EtdStatus *)status == ETD_STATUS_CANCELLED);
    CHECK(etd_render_release(render) == ETD_STATUS_OK);
    CHECK(etd_scene_release(scene) == ETD_STATUS_OK);
}

struct half {
    EtdScene *scene;
    float pixels[HEIGHT][WIDTH][3];
};

static void *render_half(void *user) {
    struct half *half = user;
    const EtdSettings settings = settings_of(8);
    EtdRender *render = begin(half->scene, &settings);
    CHECK(etd_render_run(render, NULL) == ETD_STATUS_OK);
    read_all(render, &half->pixels[0][0][0]);
    CHECK(etd_render_release(render) == ETD_STATUS_OK);
    return NULL;
}

/* One scene and another, rendered by four threads at once. */
static void threads(void) {
    EtdScene *scenes[2] = {make_scene(WIDTH, HEIGHT), make_scene(WIDTH, HEIGHT)};
    static struct half halves[4];
    pthread_t thread[4];
    for (int i = 0; i < 2; i++) {
        DONE(scenes[i], etd_scene_commit(scenes[i], NULL));
    }
    for (int i = 0; i < 4; i++) {
        halves[i].scene = scenes[i % 2];
        CHECK(pthread_create(&thread[i], NULL, render_half, &halves[i]) == 0);
    }
    for (int i = 0; i < 4; i++) {
        CHECK(pthread_join(thread[i], NULL) == 0);
        CHECK(memcmp(halves[i].pixels, halves[0].pixels, sizeof halves[0].pixels) == 0);
    }
    for (int i = 0; i < 2; i++) {
        CHECK(etd_scene_release(scenes[i]) == ETD_STATUS_OK);
    }
}

/* What rays meet, and changes that build nothing. */
static void rays_and_changes(void) {
    EtdScene *scene = make_scene(WIDTH, HEIGHT);
    DONE(scene, etd_scene_commit(scene, NULL));
    EtdRay rays[2];
    memset(rays, 0, sizeof rays);
    rays[0].origin[1] = rays[1].origin[1] = 5;
    rays[0].direction[1] = -2; /* Down, onto the ball. */
    rays[1].direction[1] = 1;
    EtdHit hits[2];
    DONE(scene, etd_scene_intersect(scene, rays, 2, 0, hits, 0));
    CHECK(hits[0].met && hits[0].shape == 1 && fabs(hits[0].distance - 3) < 1e-5);
    CHECK(fabs(hits[0].position[1] - 2) < 1e-5 && fabs(hits[0].normal[1] - 1) < 1e-5);
    CHECK(!hits[1].met);
    uint8_t occluded[2] = {9, 9};
    DONE(scene, etd_scene_occluded(scene, rays, 2, sizeof rays[0], occluded));
    CHECK(occluded[0] == 1 && occluded[1] == 0);
    float radiance[2][3], errors[2][3];
    DONE(scene, etd_scene_radiance(scene, NULL, rays, 2, 0, 64, &radiance[0][0], &errors[0][0]));
    CHECK(fabsf(radiance[1][0] - 1.0f) < 1e-5f && errors[1][0] < 1e-5f);
    /* The top of the ball sees the sky, and nothing else: half of it comes back. */
    CHECK(fabsf(radiance[0][0] - 0.5f) < 6 * errors[0][0] + 1e-5f);
    /* How the samples of images are distributed does not matter along rays. */
    EtdSettings settings = settings_of(0);
    settings.adaptive = "greedy";
    settings.reuse = "4";
    float again[2][3];
    DONE(scene, etd_scene_radiance(scene, &settings, rays, 2, 0, 64, &again[0][0], &errors[0][0]));
    CHECK(memcmp(again, radiance, sizeof again) == 0);

    /* Aside with the ball: then the ray meets the floor. */
    const uint32_t ball = 0;
    const double aside[12] = {1, 0, 0, 3, 0, 1, 0, 1, 0, 0, 1, 0};
    DONE(scene, etd_scene_set_transforms(scene, &ball, aside, 1));
    DONE(scene, etd_scene_intersect(scene, rays, 1, 0, hits, 0));
    CHECK(hits[0].met && hits[0].shape == 0 && fabs(hits[0].distance - 5) < 1e-5);
    EtdCamera camera;
    memset(&camera, 0, sizeof camera);
    camera.struct_size = sizeof camera;
    camera.eye[2] = 3;
    camera.eye[1] = 1;
    DONE(scene, etd_scene_set_camera(scene, &camera));
    EtdWork work;
    work.struct_size = sizeof work;
    DONE(scene, etd_scene_work(scene, &work));
    CHECK(work.builds == 1 && work.placements == 1 && work.cameras == 1);
    CHECK(etd_scene_release(scene) == ETD_STATUS_OK);
}

static void wrong_arguments(void) {
    const EtdStatus argument = ETD_STATUS_INVALID_ARGUMENT, invalid = ETD_STATUS_INVALID_SCENE;
    CHECK(etd_scene_create(NULL) == argument);
    EtdScene *scene = make_scene(WIDTH, HEIGHT);
    FAILS(scene, etd_scene_set_camera(scene, NULL), argument, "EtdCamera is null");
    EtdCamera camera;
    memset(&camera, 0, sizeof camera);
    FAILS(scene, etd_scene_set_camera(scene, &camera), argument, "struct_size is 0");
    camera.struct_size = sizeof camera;
    FAILS(scene, etd_scene_set_camera(scene, &camera), invalid, "same point");
    camera.eye[0] = 1;
    camera.fov = 180;
    FAILS(scene, etd_scene_set_camera(scene, &camera), invalid, "fov");
    camera.fov = 0;
    camera.eye[0] = NAN;
    CHECK(etd_scene_set_camera(scene, &camera) == invalid);

    FAILS(scene, etd_scene_load(scene, NULL), argument, "path is null");
    FAILS(scene, etd_scene_load(scene, "nowhere.toml"), ETD_STATUS_INPUT_OUTPUT, "nowhere.toml");
    FAILS(scene, etd_scene_load(scene, "\xff.toml"), argument, "UTF-8");

    EtdSurface surface;
    memset(&surface, 0, sizeof surface);
    surface.struct_size = sizeof surface;
    const double origin[3] = {0, 0, 0}, up[3] = {0, 1, 0}, far[3] = {0, HUGE_VAL, 0};
    FAILS(scene, etd_scene_add_sphere(scene, &surface, origin, -1, NULL), invalid, "radius");
    FAILS(scene, etd_scene_add_sphere(scene, &surface, NULL, 1, NULL), argument, "center is null");
    FAILS(scene, etd_scene_add_sphere(scene, NULL, origin, 1, NULL), argument, "EtdSurface");
    FAILS(scene, etd_scene_add_disk(scene, &surface, origin, far, 1, NULL), invalid, "normal");
    FAILS(scene, etd_scene_add_rectangle(scene, &surface, origin, up, up, NULL), invalid, "edge_v");
    FAILS(scene, etd_scene_add_box(scene, &surface, up, origin, NULL), invalid, "max");
    surface.material = 5;
    FAILS(scene, etd_scene_add_sphere(scene, &surface, origin, 1, NULL), invalid, "material");
    surface.material = 0;
    surface.group = 7;
    FAILS(scene, etd_scene_add_sphere(scene, &surface, origin, 1, NULL), invalid, "group");
    surface.group = 0;

    const float triangle[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    const uint32_t corners[3] = {0, 1, 3};
    EtdMesh mesh;
    memset(&mesh, 0, sizeof mesh);
    mesh.struct_size = sizeof mesh;
    mesh.positions = triangle;
    mesh.vertex_count = 3;
    mesh.indices = corners;
    mesh.triangle_count = 1;
    FAILS(scene, etd_scene_add_mesh(scene, &surface, &mesh, NULL), invalid, "vertex 3");
    mesh.position_stride = 8;
    FAILS(scene, etd_scene_add_mesh(scene, &surface, &mesh, NULL), argument, "stride of 8");
    mesh.position_stride = SIZE_MAX / 2;
    FAILS(scene, etd_scene_add_mesh(scene, &surface, &mesh, NULL), argument, "positions");
    mesh.position_stride = 0;
    mesh.vertex_count = SIZE_MAX;
    FAILS(scene, etd_scene_add_mesh(scene, &surface, &mesh, NULL), argument, "2^32");
    mesh.vertex_count = 3;
    mesh.position_format = 2;
    FAILS(scene, etd_scene_add_mesh(scene, &surface, &mesh, NULL), argument, "position_format");
    mesh.position_format = 0;
    mesh.indices = NULL;
    FAILS(scene, etd_scene_add_mesh(scene, &surface, &mesh, NULL), argument, "indices is null");

    EtdFilm film;
    memset(&film, 0, sizeof film);
    film.struct_size = sizeof film;
    film.width = 8;
    FAILS(scene, etd_scene_set_film(scene, &film), invalid, "film.size");
    film.height = 8;
    film.filter = 5;
    FAILS(scene, etd_scene_set_film(scene, &film), argument, "filter: 5");

    EtdTracing tracing;
    memset(&tracing, 0, sizeof tracing);
    tracing.struct_size = sizeof tracing;
    tracing.backend = -1;
    FAILS(scene, etd_scene_commit(scene, &tracing), argument, "backend: -1");
    tracing.backend = ETD_BACKEND_OBVHS_BVH2;
    tracing.threads = 1u << 31;
    FAILS(scene, etd_scene_commit(scene, &tracing), argument, "threads");
    tracing.threads = 1;
    DONE(scene, etd_scene_commit(scene, &tracing));

    EtdRender *render = NULL;
    EtdSettings settings = settings_of(1);
    FAILS(scene, etd_render_create(scene, &settings, NULL), argument, "render is null");
    settings.integrator = "photon-map";
    FAILS(scene, etd_render_create(scene, &settings, &render), argument, "photon-map");
    settings.integrator = NULL;
    settings.flags = 1u << 20;
    FAILS(scene, etd_render_create(scene, &settings, &render), argument, "flags");
    settings.flags = ETD_HAS_CROP;
    FAILS(scene, etd_render_create(scene, &settings, &render), argument, "crop");
    settings.flags = 0;
    settings.seconds = NAN;
    FAILS(scene, etd_render_create(scene, &settings, &render), argument, "seconds");
    settings.seconds = 0;
    settings.spp = UINT64_MAX;
    FAILS(scene, etd_render_create(scene, &settings, &render), argument, "samples");
    settings.spp = 1;
    CHECK(render == NULL);
    render = begin(scene, &settings);
    float pixels[3];
    CHECK(etd_render_add_samples(render, 0, NULL) == argument);
    CHECK(etd_render_read_pixels(render, NULL, sizeof pixels, 0, 0) == argument);
    CHECK(etd_render_read_pixels(render, pixels, sizeof pixels, 0, 0) == argument);
    CHECK(etd_render_read_pixels(render, pixels, SIZE_MAX, 4, 0) == argument);
    CHECK(etd_render_read_pixels(render, pixels, SIZE_MAX, SIZE_MAX, SIZE_MAX) == argument);
    CHECK(etd_render_read_standard_errors(render, pixels, SIZE_MAX, 0, 0) == argument);
    char text[16];
    CHECK(etd_render_error(render, text, sizeof text) > sizeof text && strlen(text) == 15);
    CHECK(etd_render_write(render, "picture.tiff") == argument);
    CHECK(etd_render_write(render, "nowhere/picture.png") == ETD_STATUS_INPUT_OUTPUT);

    EtdRay ray;
    memset(&ray, 0, sizeof ray);
    EtdHit hit;
    FAILS(scene, etd_scene_intersect(scene, &ray, 1, 0, &hit, 0), argument, "ray 0");
    ray.direction[0] = 1;
    FAILS(scene, etd_scene_intersect(scene, &ray, 1, 8, &hit, 0), argument, "stride of 8");
    FAILS(scene, etd_scene_intersect(scene, &ray, SIZE_MAX, 0, &hit, 0), argument, "rays");
    FAILS(scene, etd_scene_intersect(scene, NULL, 1, 0, &hit, 0), argument, "rays is null");
    FAILS(scene, etd_scene_intersect(scene, &ray, 1, 0, NULL, 0), argument, "hits is null");
    const uint32_t nobody = 4;
    const double flat[12] = {1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0};
    FAILS(scene, etd_scene_set_transforms(scene, &nobody, flat, 1), argument, "instances: 4");
    const uint32_t ball = 0;
    FAILS(scene, etd_scene_set_transforms(scene, &ball, flat, 1), invalid, "singular");

    /* A picture of 2 terabytes. */
    film.width = film.height = 65536;
    film.filter = 0;
    DONE(scene, etd_scene_set_film(scene, &film));
    settings.flags = ETD_LAYERS;
    EtdRender *large = NULL;
    FAILS(scene, etd_render_create(scene, &settings, &large), ETD_STATUS_OUT_OF_MEMORY, "memory");
    CHECK(large == NULL);
    /* The scene has changed since the render began. */
    CHECK(etd_render_run(render, NULL) == argument);

    CHECK(etd_render_retain(render) == ETD_STATUS_OK);
    CHECK(etd_render_release(render) == ETD_STATUS_OK);
    CHECK(etd_render_release(render) == ETD_STATUS_OK);
    CHECK(etd_scene_release(scene) == ETD_STATUS_OK);
    /* What was released, is null, or is a handle of another kind. */
    const EtdStatus handle = ETD_STATUS_INVALID_HANDLE;
    CHECK(etd_render_release(render) == handle && etd_scene_release(scene) == handle);
    CHECK(etd_render_retain(render) == handle && etd_render_cancel(render) == handle);
    CHECK(etd_render_run(render, NULL) == handle && etd_scene_commit(scene, NULL) == handle);
    CHECK(etd_scene_release(NULL) == handle && etd_render_release(NULL) == handle);
    CHECK(etd_scene_error(scene, text, sizeof text) > 0);
    EtdScene *living = make_scene(WIDTH, HEIGHT);
    CHECK(etd_render_run((EtdRender *)living, NULL) == handle);
    CHECK(etd_scene_release(living) == ETD_STATUS_OK);
}

int main(int argc, char **argv) {
    CHECK(argc >= 3 && argc % 2 == 1);
    CHECK(strncmp(etd_version(), "0.", 2) == 0);
    CHECK(strcmp(etd_status_text(ETD_STATUS_OK), "done") == 0);
    CHECK(strlen(etd_status_text(-1)) > 0);
    for (int i = 1; i < argc; i += 2) {
        a_file(argv[i], argv[i + 1]);
    }
    pictures();
    cancelling();
    cancelling_a_cache();
    adaptive();
    threads();
    rays_and_changes();
    wrong_arguments();
    puts("all is well");
    return 0;
}

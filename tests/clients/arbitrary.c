/*
 * Calls of the library with arbitrary arguments: arbitrary SEED COUNT. Pointers are null or lead somewhere, as the library has to
 * believe them; everything else may be anything. Whatever comes, there is a status, and for a failure a text.
 */

#include "small_scene.h"
#include <math.h>

static uint64_t state;

/* xorshift64*, by Marsaglia and Vigna. */
static uint64_t arbitrary(void) {
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return state * 2685821657736338717u;
}

static uint64_t below(uint64_t end) { return arbitrary() % end; }

static double number(void) {
    static const double odd[] = {0,    1,        -1,       0.5,  2,      -0.0,    NAN,
                                 1e30, HUGE_VAL, -HUGE_VAL, 1e300, 1e-300, 4.9e-324, 180};
    return odd[below(sizeof odd / sizeof odd[0])];
}

static float single(void) { return (float)number(); }

static size_t length(void) {
    static const size_t odd[] = {0, 1, 2, 3, SIZE_MAX, SIZE_MAX / 2, SIZE_MAX / 12, (size_t)1 << 50};
    return odd[below(sizeof odd / sizeof odd[0])];
}

static size_t stride(void) {
    static const size_t odd[] = {0, 0, 1, 4, 12, 24, SIZE_MAX, SIZE_MAX / 3, (size_t)1 << 62};
    return odd[below(sizeof odd / sizeof odd[0])];
}

/* The right size mostly. */
static size_t size(size_t right) { return below(8) ? right : below(3) ? length() : right + 8; }

static int32_t choice(void) { return (int32_t)below(10) - 1; }

static const char *name(void) {
    static const char *odd[] = {NULL, "", "path", "sobol", "none", "\xff\xfe", "two-phase", "ball"};
    return odd[below(sizeof odd / sizeof odd[0])];
}

static void vector(double *v) {
    for (int i = 0; i < 3; i++) {
        v[i] = number();
    }
}

static void colour(float *c) {
    for (int i = 0; i < 3; i++) {
        c[i] = single();
    }
}

/* What pointers lead to: enough for the few items that calls with a small count read. */
static double numbers[64];
static float floats[64];
static uint32_t wholes[16];
static EtdRay rays[4];
static EtdHit hits[4];
static float pixels[4 * 64];

static EtdKey keys[3];
static EtdCameraKey camera_keys[3];

static const void *somewhere(const void *place) { return below(8) ? place : NULL; }

/* A list that is as long as it is said to be, or so long that nobody reads it. */
static size_t count_of(size_t stride_) {
    const size_t count = length();
    return count > 3 || stride_ <= 24 ? count : 0;
}

static EtdImage an_image(void) {
    EtdImage image;
    memset(&image, 0, sizeof image);
    image.struct_size = size(sizeof image);
    image.width = (uint32_t)below(3);
    image.height = (uint32_t)below(3);
    image.rgb = somewhere(floats);
    image.pixel_stride = below(4) ? 0 : below(2) ? 16 : 3;
    image.scale = single();
    return image;
}

/* So many keys of a motion as there may be, mostly none or few. */
static size_t key_count(void) { return below(2) ? 0 : below(8) ? below(4) : length(); }

/* What few keys reach, or so much that nobody reads it. */
static size_t key_stride(size_t right, size_t count) {
    return count > 3 ? stride() : below(4) ? 0 : below(4) ? right : below(2) ? 8 : SIZE_MAX / 3;
}

static EtdSurface a_surface(const EtdImage *image) {
    EtdSurface surface;
    memset(&surface, 0, sizeof surface);
    surface.struct_size = size(sizeof surface);
    surface.name = name();
    surface.material = (uint32_t)below(3);
    surface.group = (uint32_t)below(4);
    colour(surface.emission);
    surface.transform = below(2) ? NULL : numbers;
    surface.emission_texture = below(4) ? NULL : image;
    surface.motion = somewhere(keys);
    surface.motion_count = key_count();
    surface.motion_stride = key_stride(sizeof keys[0], surface.motion_count);
    return surface;
}

static EtdSettings some_settings(void) {
    EtdSettings settings;
    memset(&settings, 0, sizeof settings);
    settings.struct_size = size(sizeof settings);
    settings.flags = (uint32_t)below(20);
    settings.max_bounces = (uint32_t)below(3);
    /* Nothing that takes long. */
    settings.spp = below(4) ? 1 : arbitrary() | (uint64_t)1 << 60;
    settings.seconds = below(4) ? 0 : number();
    settings.error = below(4) ? 0 : number();
    settings.confidence = below(4) ? 0 : number();
    settings.integrator = below(3) ? NULL : name();
    settings.sampler = below(3) ? NULL : name();
    settings.adaptive = below(3) ? NULL : name();
    settings.roulette = below(3) ? NULL : name();
    settings.occlusion_distance = below(3) ? 0 : number();
    settings.cache_error = below(3) ? 0 : number();
    for (int i = 0; i < 4; i++) {
        settings.crop[i] = (uint32_t)below(10);
    }
    settings.light_paths = below(3) ? NULL : name();
    settings.filter_sampling = below(3) ? NULL : name();
    return settings;
}

static void an_odd_scene(EtdScene *scene, EtdStatus *status) {
    uint32_t out;
    double a[3], b[3], c[3];
    vector(a), vector(b), vector(c);
    const double *pa = somewhere(a);
    const EtdImage image = an_image();
    const EtdSurface surface = a_surface(&image);
    const EtdSurface *ps = somewhere(&surface);
    switch (below(13)) {
    case 0: {
        EtdCamera camera;
        memset(&camera, 0, sizeof camera);
        camera.struct_size = size(sizeof camera);
        vector(camera.eye), vector(camera.target), vector(camera.up);
        camera.fov = number();
        camera.lens_radius = number();
        camera.focus_distance = number();
        camera.shutter = below(2) ? NULL : numbers;
        camera.motion = somewhere(camera_keys);
        camera.motion_count = key_count();
        camera.motion_stride = key_stride(sizeof camera_keys[0], camera.motion_count);
        *status = etd_scene_set_camera(scene, somewhere(&camera));
        break;
    }
    case 1: {
        EtdFilm film;
        memset(&film, 0, sizeof film);
        film.struct_size = size(sizeof film);
        film.width = film.height = (uint32_t)below(5) ? (uint32_t)below(5) : 65535;
        film.filter = choice();
        film.filter_radius = number();
        *status = etd_scene_set_film(scene, somewhere(&film));
        break;
    }
    case 2: {
        EtdMaterial material;
        memset(&material, 0, sizeof material);
        material.struct_size = size(sizeof material);
        material.name = name();
        material.model = choice();
        colour(material.color), colour(material.specular), colour(material.eta), colour(material.k);
        material.texture = below(2) ? NULL : &image;
        material.exponent = single();
        material.roughness = single();
        material.ior = single();
        material.metallic = single();
        material.transmission = single();
        material.one_sided = (uint32_t)below(2);
        material.alpha_texture = below(4) ? NULL : &image;
        material.specular_texture = below(4) ? NULL : &image;
        material.normal_map = below(4) ? NULL : &image;
        material.normal_strength = single();
        material.alpha = single();
        material.bump_map = below(4) ? NULL : &image;
        material.bump_height = single();
        material.clear_coat = single();
        material.clear_coat_roughness = single();
        material.clear_coat_ior = single();
        *status = etd_scene_add_material(scene, somewhere(&material), &out);
        break;
    }
    case 3: {
        EtdMesh mesh;
        memset(&mesh, 0, sizeof mesh);
        mesh.struct_size = size(sizeof mesh);
        mesh.positions = somewhere(numbers);
        mesh.position_stride = stride();
        mesh.vertex_count = count_of(mesh.position_stride);
        mesh.position_format = choice();
        mesh.normals = below(2) ? NULL : floats;
        mesh.normal_stride = mesh.position_stride;
        mesh.uvs = below(2) ? NULL : floats;
        mesh.uv_stride = mesh.position_stride;
        mesh.indices = somewhere(wholes);
        mesh.index_stride = below(2) ? 0 : 12;
        mesh.triangle_count = length();
        *status = etd_scene_add_mesh(scene, ps, somewhere(&mesh), &out);
        break;
    }
    case 4:
        *status = etd_scene_add_sphere(scene, ps, pa, number(), somewhere(&out) ? &out : NULL);
        break;
    case 5:
        *status = etd_scene_add_disk(scene, ps, pa, b, number(), &out);
        break;
    case 6:
        *status = etd_scene_add_rectangle(scene, ps, pa, b, c, &out);
        break;
    case 7:
        *status = etd_scene_add_box(scene, ps, pa, b, &out);
        break;
    case 8:
        *status = etd_scene_add_group(scene, name(), &out);
        break;
    case 9: {
        EtdInstance instance;
        memset(&instance, 0, sizeof instance);
        instance.struct_size = size(sizeof instance);
        instance.name = name();
        instance.of = (uint32_t)below(4);
        instance.group = (uint32_t)below(4);
        instance.transform = below(2) ? NULL : numbers;
        instance.motion = somewhere(keys);
        instance.motion_count = key_count();
        instance.motion_stride = key_stride(sizeof keys[0], instance.motion_count);
        *status = etd_scene_add_instance(scene, somewhere(&instance), &out);
        break;
    }
    case 10: {
        EtdLight light;
        memset(&light, 0, sizeof light);
        light.struct_size = size(sizeof light);
        light.kind = choice();
        colour(light.value);
        light.panorama = below(2) ? NULL : &image;
        vector(light.position), vector(light.target), vector(light.direction);
        light.cone = number();
        light.penumbra = number();
        light.transform = below(4) ? NULL : numbers;
        *status = etd_scene_add_light(scene, somewhere(&light));
        break;
    }
    case 11:
        *status = etd_scene_load(scene, name());
        break;
    default: {
        const size_t count = length();
        *status = etd_scene_set_transforms(scene, somewhere(wholes), somewhere(numbers), count);
        break;
    }
    }
}

static EtdStatus a_query(EtdScene *scene) {
    for (int i = 0; i < 4; i++) {
        vector(rays[i].origin), vector(rays[i].direction);
        rays[i].min_distance = below(3) ? 0 : number();
        rays[i].max_distance = below(3) ? 0 : number();
        rays[i].time = below(3) ? 0 : number();
    }
    const size_t ray_stride = below(3) ? 0 : below(2) ? sizeof rays[0] : SIZE_MAX / 2;
    const EtdSettings settings = some_settings();
    uint8_t occluded[4];
    const size_t count = length();
    switch (below(3)) {
    case 0:
        return etd_scene_intersect(scene, somewhere(rays), count, ray_stride,
                                   (EtdHit *)somewhere(hits), below(3) ? 0 : 8);
    case 1:
        return etd_scene_occluded(scene, somewhere(rays), count, ray_stride,
                                  (uint8_t *)somewhere(occluded));
    default:
        return etd_scene_radiance(scene, somewhere(&settings), somewhere(rays), count, ray_stride,
                                  below(3), (float *)somewhere(pixels),
                                  below(2) ? NULL : pixels + 16);
    }
}

static EtdStatus a_render(EtdScene *scene) {
    const EtdSettings settings = some_settings();
    EtdRender *render = NULL;
    const EtdStatus begun = etd_render_create(scene, below(9) ? &settings : NULL, &render);
    if (begun != ETD_STATUS_OK) {
        CHECK(render == NULL);
        return begun;
    }
    EtdRenderInfo info;
    memset(&info, 0, sizeof info);
    info.struct_size = sizeof info;
    CHECK(etd_render_info(render, &info) == ETD_STATUS_OK);
    EtdStatus status = ETD_STATUS_OK;
    /* Long renders are not run. */
    const int is_short = settings.spp == 1 && settings.error == 0 && settings.seconds == 0;
    const int is_small = info.width <= 8 && info.height <= 8;
    if (is_short && is_small) {
        status = etd_render_run(render, NULL);
        if (below(2)) {
            status = etd_render_add_samples(render, below(2) ? 1 : UINT64_MAX, NULL);
        }
        const size_t bytes = below(2) ? sizeof pixels : length();
        const size_t fits = bytes <= sizeof pixels ? bytes : 0;
        status = etd_render_read_pixels(render, (float *)somewhere(pixels), fits, stride(), stride());
        status = etd_render_read_layer(render, name(), pixels, fits, stride(), stride());
        info.struct_size = size(sizeof info);
        status = etd_render_info(render, info.struct_size > sizeof info ? NULL : &info);
    }
    if (status != ETD_STATUS_OK && status != ETD_STATUS_CANCELLED) {
        CHECK(etd_render_error(render, NULL, 0) > 0);
    }
    CHECK(etd_render_release(render) == ETD_STATUS_OK);
    CHECK(etd_render_release(render) == ETD_STATUS_INVALID_HANDLE);
    CHECK(etd_render_retain((EtdRender *)(uintptr_t)arbitrary()) == ETD_STATUS_INVALID_HANDLE);
    return status;
}

int main(int argc, char **argv) {
    CHECK(argc == 3);
    state = strtoull(argv[1], NULL, 10) * 2 + 1;
    const unsigned long calls = strtoul(argv[2], NULL, 10);
    unsigned long of_status[11] = {0};
    EtdScene *scene = NULL;
    for (unsigned long i = 0; i < calls; i++) {
        if (i % 100 == 0) {
            if (scene) {
                CHECK(etd_scene_release(scene) == ETD_STATUS_OK);
                CHECK(etd_scene_release(scene) == ETD_STATUS_INVALID_HANDLE);
            }
            /* Every other one begins as a scene that can be rendered. */
            if (i % 200 == 0) {
                CHECK(etd_scene_create(&scene) == ETD_STATUS_OK);
            } else {
                scene = make_scene(4, 4);
                DONE(scene, etd_scene_commit(scene, NULL));
            }
        }
        for (int k = 0; k < 64; k++) {
            numbers[k] = below(2) ? (double)(k % 5 == 0) : number();
            floats[k] = below(2) ? 0.5f : single();
            wholes[k % 16] = (uint32_t)below(4);
        }
        for (int k = 0; k < 3; k++) {
            keys[k].time = below(8) ? k : number();
            memcpy(keys[k].transform, numbers + k, sizeof keys[k].transform);
            camera_keys[k].time = below(8) ? k : number();
            vector(camera_keys[k].eye), vector(camera_keys[k].target), vector(camera_keys[k].up);
        }
        EtdStatus status = ETD_STATUS_OK;
        const uint64_t kind = below(20);
        if (kind < 12) {
            an_odd_scene(scene, &status);
        } else if (kind < 16) {
            status = a_query(scene);
        } else if (kind < 19) {
            status = a_render(scene);
        } else {
            EtdTracing tracing;
            memset(&tracing, 0, sizeof tracing);
            tracing.struct_size = size(sizeof tracing);
            tracing.backend = choice();
            tracing.precision = (int32_t)below(3);
            tracing.threads = (uint32_t)(below(8) ? below(3) : arbitrary());
            status = etd_scene_commit(scene, somewhere(&tracing));
        }
        CHECK((int)status >= 0 && (int)status < ETD_STATUS_INTERNAL);
        of_status[status]++;
    }
    CHECK(etd_scene_release(scene) == ETD_STATUS_OK);
    for (int status = 0; status < 11; status++) {
        printf("%s: %lu\n", etd_status_text(status), of_status[status]);
    }
    CHECK(of_status[ETD_STATUS_OK] > calls / 20);
    puts("all is well");
    return 0;
}

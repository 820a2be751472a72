/* What there is no memory for is refused with a status and a text, and the program goes on: counts that no machine has, and what
 * is more than this process may take by a limit that it sets itself. */

#include "small_scene.h"
#include <sys/resource.h>
#include <unistd.h>

enum { SIDE = 601 };

/* A mesh, a picture and rays that say that they are larger than any memory: nothing of them is read. */
static void absurd_counts(void) {
    const EtdStatus memory = ETD_STATUS_OUT_OF_MEMORY;
    EtdScene *scene = make_scene(8, 8);
    static const double corner[3] = {0, 0, 0};
    static const uint32_t indices[3] = {0, 0, 0};
    EtdSurface surface;
    memset(&surface, 0, sizeof surface);
    surface.struct_size = sizeof surface;
    EtdMesh mesh;
    memset(&mesh, 0, sizeof mesh);
    mesh.struct_size = sizeof mesh;
    mesh.positions = corner;
    mesh.position_format = ETD_FORMAT_FLOAT64;
    mesh.indices = indices;
    mesh.vertex_count = 3;
    mesh.triangle_count = UINT32_MAX;
    FAILS(scene, etd_scene_add_mesh(scene, &surface, &mesh, NULL), memory, "4294967295 triangles");
    mesh.vertex_count = UINT32_MAX;
    FAILS(scene, etd_scene_add_mesh(scene, &surface, &mesh, NULL), memory, "4294967295 vertices");

    DONE(scene, etd_scene_commit(scene, NULL));
    EtdRay ray;
    EtdHit hit;
    memset(&ray, 0, sizeof ray);
    const size_t rays = (size_t)1 << 50;
    FAILS(scene, etd_scene_intersect(scene, &ray, rays, 0, &hit, 0), memory, "rays");
    CHECK(etd_scene_release(scene) == ETD_STATUS_OK);
}

/* Leaves this process so many bytes beyond what it has. */
static void leave(size_t bytes) {
    FILE *file = fopen("/proc/self/statm", "r");
    CHECK(file != NULL);
    unsigned long pages = 0;
    CHECK(fscanf(file, "%lu", &pages) == 1);
    CHECK(fclose(file) == 0);
    struct rlimit limit;
    CHECK(getrlimit(RLIMIT_AS, &limit) == 0);
    limit.rlim_cur = bytes == SIZE_MAX ? limit.rlim_max : pages * sysconf(_SC_PAGESIZE) + bytes;
    CHECK(setrlimit(RLIMIT_AS, &limit) == 0);
}

/* A hilly floor of 720000 triangles. */
static void add_hills(EtdScene *scene) {
    static float positions[SIDE][SIDE][3];
    static uint32_t indices[SIDE - 1][SIDE - 1][2][3];
    for (uint32_t y = 0; y < SIDE; y++) {
        for (uint32_t x = 0; x < SIDE; x++) {
            positions[y][x][0] = (float)x;
            positions[y][x][1] = (float)(x * y % 7);
            positions[y][x][2] = -(float)y;
            if (x + 1 < SIDE && y + 1 < SIDE) {
                const uint32_t here = y * SIDE + x, above = here + SIDE;
                const uint32_t both[2][3] = {{here, here + 1, above}, {above, here + 1, above + 1}};
                memcpy(indices[y][x], both, sizeof both);
            }
        }
    }
    EtdSurface surface;
    memset(&surface, 0, sizeof surface);
    surface.struct_size = sizeof surface;
    EtdMesh mesh;
    memset(&mesh, 0, sizeof mesh);
    mesh.struct_size = sizeof mesh;
    mesh.positions = positions;
    mesh.vertex_count = SIDE * SIDE;
    mesh.indices = &indices[0][0][0][0];
    mesh.triangle_count = (SIDE - 1) * (SIDE - 1) * 2;
    DONE(scene, etd_scene_add_mesh(scene, &surface, &mesh, NULL));
}

/* A scene and a picture that are too large for what is left, and are not once there is more. */
static void a_limit(void) {
    const EtdStatus memory = ETD_STATUS_OUT_OF_MEMORY;
    EtdScene *scene = make_scene(8, 8);
    add_hills(scene);
    leave((size_t)100 << 20);
    FAILS(scene, etd_scene_commit(scene, NULL), memory, "no memory for the scene");
    leave(SIZE_MAX);
    DONE(scene, etd_scene_commit(scene, NULL));

    EtdFilm film;
    memset(&film, 0, sizeof film);
    film.struct_size = sizeof film;
    film.width = film.height = 4096;
    DONE(scene, etd_scene_set_film(scene, &film));
    EtdSettings settings;
    memset(&settings, 0, sizeof settings);
    settings.struct_size = sizeof settings;
    settings.flags = ETD_LAYERS | ETD_HAS_CROP;
    settings.crop[2] = settings.crop[3] = 4096;
    EtdRender *render = NULL;
    leave((size_t)100 << 20);
    FAILS(scene, etd_render_create(scene, &settings, &render), memory, "4096 x 4096");
    CHECK(render == NULL);
    /* There is room for the sums of this part, but not for the estimate of its error. */
    settings.crop[2] = settings.crop[3] = 1024;
    leave((size_t)300 << 20);
    FAILS(scene, etd_render_create(scene, &settings, &render), memory, "1024 x 1024");
    CHECK(render == NULL);
    /* A smaller part has room. */
    settings.crop[2] = settings.crop[3] = 8;
    settings.spp = 1;
    DONE(scene, etd_render_create(scene, &settings, &render));
    leave(SIZE_MAX);
    CHECK(etd_render_run(render, NULL) == ETD_STATUS_OK);
    CHECK(etd_render_release(render) == ETD_STATUS_OK);
    CHECK(etd_scene_release(scene) == ETD_STATUS_OK);
}

int main(void) {
    absurd_counts();
    a_limit();
    puts("all is well");
    return 0;
}

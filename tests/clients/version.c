/* Prints the version of the library that it is linked with. */

#include <etendue.h>
#include <stdio.h>

int main(void) {
    EtdScene *scene = 0;
    if (etd_scene_create(&scene) != ETD_STATUS_OK || etd_scene_release(scene) != ETD_STATUS_OK) {
        return 1;
    }
    puts(etd_version());
    return 0;
}

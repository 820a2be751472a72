/* What the clients share: checks that say where they failed. */

#ifndef CHECK_H
#define CHECK_H

#include <etendue.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHECK(condition)                                                                           \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition);                        \
            exit(1);                                                                               \
        }                                                                                          \
    } while (0)

/* A call that has to succeed, else the scene's text is printed. */
#define DONE(scene, call)                                                                          \
    do {                                                                                           \
        EtdStatus status_ = (call);                                                                \
        if (status_ != ETD_STATUS_OK) {                                                            \
            char text_[512];                                                                       \
            etd_scene_error((scene), text_, sizeof text_);                                         \
            fprintf(stderr, "%s:%d: %s: %s: %s\n", __FILE__, __LINE__, #call,                      \
                    etd_status_text(status_), text_);                                              \
            exit(1);                                                                               \
        }                                                                                          \
    } while (0)

/* A call that has to fail like this, and leave the scene a text that has these words. */
#define FAILS(scene, call, expected, words)                                                        \
    do {                                                                                           \
        EtdStatus status_ = (call);                                                                \
        char text_[512];                                                                           \
        const size_t length_ = etd_scene_error((scene), text_, sizeof text_);                      \
        if (status_ != (expected) || !strstr(text_, (words)) || length_ != strlen(text_)) {        \
            fprintf(stderr, "%s:%d: %s\nexpected %s: %s\nfound %s: %s\n", __FILE__, __LINE__,      \
                    #call, etd_status_text(expected), (words), etd_status_text(status_), text_);   \
            exit(1);                                                                               \
        }                                                                                          \
    } while (0)

#endif

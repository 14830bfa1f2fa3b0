// Shapes that are drawn, flooded and boxed; loops over constants, arrays, a switch.
#include <scamp5.hpp>
#include "helpers.hpp"
using namespace SCAMP5_PE;

enum mode_t { FILLED, OUTLINE, BOTH };

namespace shapes
{
    static const int centres[3][2] = { {20, 20}, {40, 24}, {30, 50} };

    void draw(dreg_t reg, int count)
    {
        scamp5_draw_begin(reg);
        for (int i = 0; i < count; i++) {
            if (i % 2 == 0)
                scamp5_draw_circle(centres[i][0], centres[i][1], 5 + i * 2);
            else
                scamp5_draw_rect(centres[i][0], centres[i][1], centres[i][0] + 4, centres[i][1] + 4);
        }
        scamp5_draw_end();
    }
}

int main()
{
    vs_init();
    vs_handle display;
    display = vs_gui_add_display("boxes", 0, 0);
    mode_t mode = BOTH;
    volatile int iterations;
    vs_gui_add_slider("iterations", 0, 20, 10, &iterations);
    uint8_t box[4];
    uint8_t events[2 * 100];
    bool first = true;

    while (1) {
        vs_frame_loop_control();
        if (first) {
            first = false;
            load_centred(R9, 30, 30, 12);
        }
        switch (mode) {
            case FILLED:
                scamp5_kernel_begin(); SET(R5); scamp5_kernel_end();
                break;
            case BOTH:
            case OUTLINE:
                shapes::draw(R5, 3);
                break;
            default:
                break;
        }
        scamp5_load_point(R6, 30, 30);
        scamp5_kernel_begin();
            SET (RN, RS, RE, RW);
            NOT(R7, R5);
        scamp5_kernel_end();
        scamp5_flood(R6, R7, 0, iterations);
        for (int n = 0; n < 4; n++) {
            scamp5_kernel_begin();
                DNEWS(R8, R6, east | north, 0);
                MOV(R6, R8);
            scamp5_kernel_end();
        }
        scamp5_scan_boundingbox(R6, box);
        scamp5_scan_events(R6, events, 100);
        int sum = 0;
        for (int n = 0; n < 100; n++) {
            if (events[2 * n] == 0 && events[2 * n + 1] == 0) {
                break;
            }
            sum += events[2 * n];
        }
        if (sum > 50) {
            vs_post_text("%d\n", sum);
        }
        scamp5_display_boundingbox(display, box, 1);
        if (box[0] > 3) {
            scamp5_output_image(R6, display);
        }
    }
}

// A threshold with a slider, the difference to the frame before, and what both look like.
#include <scamp5.hpp>
#include "helpers.hpp"

using namespace SCAMP5_PE;

#define EDGES   S0          // a register alias
#define SHIFTS  3
#define KEEP(to, from) { \
    mov(to, from); \
}

const areg_t PICTURE = A;
const areg_t BEFORE = B;
vs_stopwatch timer;

void compare(dreg_t result, areg_t left, areg_t right, int by);

int main()
{
    vs_init();
    const int size = 2;
    auto display_0 = vs_gui_add_display("picture", 0, 0, size);
    auto display_1 = vs_gui_add_display("what moved", 0, size, size);

    int threshold = 12;
    vs_gui_add_slider("threshold", -127, 127, threshold, &threshold);
    int clean = 1;
    vs_gui_add_switch("clean", clean == 1, &clean);
    auto button = vs_gui_add_button("once");
    vs_on_gui_update(button, [&](int32_t value) { threshold = value; });

    while (true) {
        timer.reset();
        vs_disable_frame_trigger();
        vs_frame_loop_control();

        scamp5_kernel_begin();
            KEEP(BEFORE, PICTURE)
            get_image(PICTURE, F);
        scamp5_kernel_end();

        compare(EDGES, PICTURE, BEFORE, threshold);

        if (clean) {
            scamp5_kernel_begin();
                // the same words again and again
                for (int i = 0; i < SHIFTS; i++) {
                    DNEWS(R11, EDGES, east);
                    OR(EDGES, R11);
                }
            scamp5_kernel_end();
        }

        if (vs_gui_is_on()) {
            scamp5_output_image(PICTURE, display_0);
            scamp5_output_image(EDGES, display_1);
        }
        int spent = timer.get_usec();
        int rate = 1000000 / spent;
        vs_post_text("%d us, %d frames/s\n", spent, rate);
    }
    return 0;
}

void compare(dreg_t result, areg_t left, areg_t right, int by)
{
    scamp5_in(F, by);
    scamp5_dynamic_kernel_begin();
        sub(E, left, right);
        abs(D, E);
        sub(E, D, F);
        where(E);
            MOV(result, FLAG);
        all();
    scamp5_dynamic_kernel_end();
}

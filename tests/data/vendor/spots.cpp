// Counts the bright spots, as hosts do it: find one, flood it, take it away, and look again. How
// often that runs, the picture decides; the threshold follows the light.
#include <scamp5.hpp>
using namespace SCAMP5_PE;

const int MOST = 20;
uint8_t spots[MOST][2];

// The first spot that is left moves from R10 to R11; its height.
int take(uint8_t *at) {
    uint8_t box[4];
    scamp5_scan_events(R10, at, 1);
    scamp5_load_point(R11, at[1], at[0]);
    scamp5_flood(R11, R10, 0);
    scamp5_scan_boundingbox(R11, box);
    scamp5_kernel_begin();
        NOT(S1, R11);
        AND(S2, R10, S1);
        MOV(R10, S2);
    scamp5_kernel_end();
    return box[2] - box[0] + 1;
}

int main() {
    vs_init();
    auto shown = vs_gui_add_display("spots", 0, 0);
    int threshold = 30;
    vs_gui_add_slider("threshold", 0, 127, threshold, &threshold);
    int frame = 0, tallest = 0;
    while (1) {
        vs_frame_loop_control();
        scamp5_in(E, threshold);
        scamp5_kernel_begin();
            get_image(A, F);
            sub(A, A, E);
            where(A);
                MOV(R5, FLAG);
            all();
            MOV(R10, R5);
        scamp5_kernel_end();
        int count = 0;
        while (scamp5_global_or(R10) && count < MOST) {
            int height = take(spots[count]);
            tallest = std::max(tallest, height);
            if (height > 1) count++;
        }
        scamp5_output_image(R5, shown);
        vs_post_text("frame %d: %d spots, the tallest of %d rows\n", frame++, count, tallest);
    }
    return 0;
}

/* The reference world in plain C: the rival of the compiled world in world_against_c.py.
 *
 * The same algorithm on the same data: SplitMix64 keys, a near list of boxes in float32 relative
 * to the corner of the agent's cell, boxes judged by range and wedge, rays cast at four boxes at a
 * time, contact along the step, another free place after it. Only what the reference world needs:
 * one layer of upright white boxes, periodic edges, a point that goes ahead and sideways, one grey
 * eye with a multiple of 16 rays.
 *
 * cc -O3 -march=native -ffast-math -shared -fPIC
 */

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#define TILE 16
#define SPARE 4
#define MOST_NEAR 1024
#define MOST_CHUNKS 256
#define EIGHT 8
#define PLACE_DRAWS 64
#define PAST_BLOCKED_M 0.1
#define TOUCHING_M 1e-6
#define STEEPEST 1e-12

enum { X, Y, HALF_LENGTH, HALF_WIDTH, PAINT, ROWS };

typedef struct {
    double dt_s, width_m, side_m, chunk_m, ahead_m, behind_m, aside_m, reach_m;
    double width_low_m, width_high_m, length_low_m, length_high_m, range_m;
    int64_t across, stream, columns, count_steps, rays;
    const double *counts;      /* (count_steps): probability of at most so many in a chunk */
    const float *ahead, *left; /* (rays): directions, a multiple of TILE of them */
} World;

typedef struct { /* AGENT_DTYPE of params.py */
    int64_t world, cell_x, cell_y, steps, contacts;
    uint64_t seed, lane, draws;
    double x_m, y_m, heading_rad, distance_m, linear_mps, lateral_mps, angular_radps;
    int64_t looks, is_inside;
} Agent;

typedef struct {
    Agent *state;    /* (n) */
    int64_t *counts; /* (n): boxes in use */
    float *boxes;    /* (n, ROWS, columns) */
    uint8_t *stack;  /* (n, rays) */
} Agents;

/* Random numbers: a function of a key and a counter. */

static const uint64_t GAMMA = 0x9E3779B97F4A7C15u;

static inline uint64_t mixed(uint64_t z) {
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}
static inline uint64_t joined(uint64_t key, uint64_t part) {
    return mixed(key ^ mixed(part * GAMMA + GAMMA));
}
static inline uint64_t number(uint64_t key, uint64_t counter) {
    return mixed(key + (counter + 1) * GAMMA);
}
static inline double uniform(uint64_t bits) { return (double)(int64_t)(bits >> 11) * 0x1p-53; }
static inline double first_half(uint64_t bits) { return (double)(int64_t)(bits >> 32) * 0x1p-32; }
static inline double second_half(uint64_t bits) {
    return (double)(int64_t)(bits & 0xFFFFFFFFu) * 0x1p-32;
}
static inline double between(double low, double high, double draw) {
    return low + (high - low) * draw;
}

enum { VERSION = 2, OBSTACLES = 0, AGENTS = 1, BLOCK = 64, PLACE = 1, SIZE = 2 };

static inline uint64_t stream_key(const World *world, uint64_t seed, uint64_t what) {
    return joined(joined(joined(0, VERSION), seed), ((uint64_t)world->stream << 16) | what);
}

static inline uint64_t draw(const World *world, Agent *agent) {
    return number(joined(stream_key(world, agent->seed, AGENTS), agent->lane), agent->draws++);
}

/* What is near: gathered where an agent enters another cell. In phases over flat arrays, without
 * branches, so that each becomes vector instructions: the chunks in reach, how many obstacles each
 * has, one entry an obstacle, its place and size, and those that reach into the near box. */

static inline double larger(double a, double b) { return a > b ? a : b; }

static inline int64_t around(int64_t j, int64_t across) {
    if (j >= 0 && j < across) return j; /* a division that is seldom needed */
    return ((j % across) + across) % across;
}

static inline bool is_beyond(double x, double length, double y, double width, double farthest) {
    const double away_x = larger(fabs(x) - length, 0.0), away_y = larger(fabs(y) - width, 0.0);
    return away_x * away_x + away_y * away_y > farthest * farthest;
}

typedef struct { /* chunks in reach, by column: key, corner, obstacles */
    int count;
    uint64_t key[MOST_CHUNKS];
    double draw[MOST_CHUNKS];
    float x[MOST_CHUNKS], y[MOST_CHUNKS];
    int64_t obstacles[MOST_CHUNKS];
} Chunks;

typedef struct { /* obstacles drawn, by column, with room for one EIGHT too many */
    uint64_t key[MOST_NEAR + EIGHT];
    float x[MOST_NEAR + EIGHT], y[MOST_NEAR + EIGHT];
    float half_length[MOST_NEAR], half_width[MOST_NEAR];
    bool reaches[MOST_NEAR];
} Drawn;

static void list_chunks(const World *world, const Agent *agent, Chunks *chunks) {
    const double side = world->side_m, chunk_m = world->chunk_m, reach = world->reach_m;
    const double farthest = larger(world->ahead_m, world->behind_m) + sqrt(2.0) * reach;
    const int first_i = (int)floor((-world->behind_m - reach) / chunk_m);
    const int last_i = (int)floor((chunk_m + world->ahead_m + reach) / chunk_m);
    const int first_j = (int)floor((-world->aside_m - reach) / side);
    const int last_j = (int)floor((side + world->aside_m + reach) / side);
    const uint64_t key = stream_key(world, agent->seed, OBSTACLES);
    int n = 0;
    for (int i = first_i; i <= last_i; i++) {
        const uint64_t column = joined(key, (uint64_t)(agent->cell_x + i));
        for (int j = first_j; j <= last_j; j++) {
            const uint64_t row = (uint64_t)around(agent->cell_y + j, world->across);
            chunks->key[n] = column ^ mixed(row * GAMMA + GAMMA);
            chunks->x[n] = (float)(i * chunk_m);
            chunks->y[n] = (float)(j * side);
            n += !is_beyond(i * chunk_m, chunk_m, j * side, side, farthest);
        }
    }
    chunks->count = n;
}

static void count_obstacles(const World *world, Chunks *chunks) {
    for (int c = 0; c < chunks->count; c++) {
        chunks->key[c] = mixed(chunks->key[c]);
        chunks->draw[c] = uniform(number(chunks->key[c], 0));
        chunks->obstacles[c] = 0;
    }
    bool more = true; /* few chunks have passed the first eight */
    for (int64_t first = 0; first < world->count_steps && more; first += EIGHT) {
        const int64_t next = first + EIGHT;
        const int64_t last = next < world->count_steps ? next : world->count_steps;
        for (int64_t k = first; k < last; k++) {
            const double passed = world->counts[k];
            for (int c = 0; c < chunks->count; c++)
                chunks->obstacles[c] += chunks->draw[c] >= passed;
        }
        more = false;
        for (int c = 0; c < chunks->count; c++) more |= chunks->obstacles[c] == last;
    }
}

static int spread(const Chunks *restrict chunks, Drawn *restrict drawn) {
    int n = 0;
    for (int c = 0; c < chunks->count && n + chunks->obstacles[c] <= MOST_NEAR; c++) {
        for (int k = 0; k < chunks->obstacles[c]; k += EIGHT)
            for (int e = 0; e < EIGHT; e++) {
                const uint64_t counter = (uint64_t)((k + e) * BLOCK + PLACE + 1);
                drawn->key[n + k + e] = chunks->key[c] + counter * GAMMA;
                drawn->x[n + k + e] = chunks->x[c];
                drawn->y[n + k + e] = chunks->y[c];
            }
        n += (int)chunks->obstacles[c];
    }
    return n;
}

static void draw_obstacles(const World *world, Drawn *drawn, int count) {
    const double back = -world->behind_m, front = world->chunk_m + world->ahead_m;
    const double right = -world->aside_m, left = world->side_m + world->aside_m;
    for (int k = 0; k < count; k++) {
        const uint64_t place = mixed(drawn->key[k]), size = mixed(drawn->key[k] + GAMMA);
        const double x = first_half(place) * world->chunk_m + drawn->x[k];
        const double y = second_half(place) * world->side_m + drawn->y[k];
        const double half_width =
            0.5 * between(world->width_low_m, world->width_high_m, first_half(size));
        const double half_length =
            0.5 * between(world->length_low_m, world->length_high_m, second_half(size));
        drawn->x[k] = (float)x;
        drawn->y[k] = (float)y;
        drawn->half_length[k] = (float)half_length;
        drawn->half_width[k] = (float)half_width;
        drawn->reaches[k] = (larger(back - x, x - front) <= half_length) &
                            (larger(right - y, y - left) <= half_width);
    }
}

static void gather(const World *world, const Agent *agent, int64_t *count, float *restrict boxes) {
    const int64_t columns = world->columns;
    Chunks chunks;
    Drawn drawn;
    list_chunks(world, agent, &chunks);
    count_obstacles(world, &chunks);
    const int all = spread(&chunks, &drawn);
    draw_obstacles(world, &drawn, all);
    int64_t n = 0;
    for (int k = 0; k < all; k++) {
        boxes[X * columns + n] = drawn.x[k];
        boxes[Y * columns + n] = drawn.y[k];
        boxes[HALF_LENGTH * columns + n] = drawn.half_length[k];
        boxes[HALF_WIDTH * columns + n] = drawn.half_width[k];
        n += drawn.reaches[k] & (n < columns - SPARE);
    }
    for (int64_t k = 0; k < n; k++) boxes[PAINT * columns + k] = 0xFFFFFF;
    *count = n;
}

/* Where an agent stands. */

static inline bool set_place(const World *world, Agent *agent, double x_m, int64_t cell_y,
                             double y_m) {
    const int64_t before_x = agent->cell_x, before_y = agent->cell_y;
    const double steps_x = floor(x_m / world->chunk_m), steps_y = floor(y_m / world->side_m);
    agent->cell_x += (int64_t)steps_x;
    agent->x_m = x_m - steps_x * world->chunk_m;
    agent->cell_y = around(cell_y + (int64_t)steps_y, world->across);
    agent->y_m = y_m - steps_y * world->side_m;
    return agent->cell_x != before_x || agent->cell_y != before_y;
}

static bool touches(const World *world, const Agent *agent, int64_t count, const float *boxes) {
    const int64_t columns = world->columns;
    int found = 0;
    for (int64_t k = 0; k < count; k++) {
        const double away_x = larger(
            fabs(boxes[X * columns + k] - agent->x_m) - boxes[HALF_LENGTH * columns + k], 0.0);
        const double away_y = larger(
            fabs(boxes[Y * columns + k] - agent->y_m) - boxes[HALF_WIDTH * columns + k], 0.0);
        found += away_x * away_x + away_y * away_y <= TOUCHING_M * TOUCHING_M;
    }
    return found > 0;
}

static void go_to_free_place(const World *world, Agent *agent, int64_t *count, float *boxes,
                             bool anew) {
    for (;;) {
        for (int tried = 0; tried < PLACE_DRAWS; tried++) {
            const double y_m = world->width_m * uniform(draw(world, agent));
            const bool moved = set_place(world, agent, agent->x_m, 0, y_m);
            if (moved || anew) gather(world, agent, count, boxes);
            anew = false;
            if (!touches(world, agent, *count, boxes)) return;
        }
        set_place(world, agent, agent->x_m + PAST_BLOCKED_M, agent->cell_y, agent->y_m);
    }
}

/* Moving. */

static inline double meets_box(double x, double y, double half_length, double half_width,
                               double per_ahead, double per_left) {
    const double middle_x = x * per_ahead, reach_x = half_length * fabs(per_ahead);
    const double middle_y = y * per_left, reach_y = half_width * fabs(per_left);
    const double enters_x = middle_x - reach_x, leaves_x = middle_x + reach_x;
    const double enters_y = middle_y - reach_y, leaves_y = middle_y + reach_y;
    const double enters = enters_x > enters_y ? enters_x : enters_y;
    const double leaves = leaves_x < leaves_y ? leaves_x : leaves_y;
    if (enters > leaves || leaves < 0.0) return 1e300;
    return enters > 0.0 ? enters : 0.0;
}

static double free_share(const World *world, const Agent *agent, int64_t count,
                         const float *restrict boxes, double way_x, double way_y) {
    const int64_t columns = world->columns;
    const float x = (float)(agent->x_m + 0.5 * way_x), y = (float)(agent->y_m + 0.5 * way_y);
    const float rx = (float)(0.5 * fabs(way_x) + TOUCHING_M);
    const float ry = (float)(0.5 * fabs(way_y) + TOUCHING_M);
    int touched = 0;
    for (int64_t k = 0; k < count; k++)
        touched += (fabsf(boxes[X * columns + k] - x) <= boxes[HALF_LENGTH * columns + k] + rx) &
                   (fabsf(boxes[Y * columns + k] - y) <= boxes[HALF_WIDTH * columns + k] + ry);
    if (!touched) return 1e300;
    const double length = sqrt(way_x * way_x + way_y * way_y);
    const double ahead = way_x / length, left = way_y / length;
    const double per_ahead = 1.0 / copysign(larger(fabs(ahead), STEEPEST), ahead);
    const double per_left = 1.0 / copysign(larger(fabs(left), STEEPEST), left);
    double first = 1e300;
    for (int64_t k = 0; k < count; k++) {
        const double met = meets_box(boxes[X * columns + k] - agent->x_m,
                                     boxes[Y * columns + k] - agent->y_m,
                                     boxes[HALF_LENGTH * columns + k],
                                     boxes[HALF_WIDTH * columns + k], per_ahead, per_left);
        first = met < first ? met : first;
    }
    return first > length ? 1e300 : first / length;
}

static bool step(const World *world, const Agents *agents, int64_t i, const double *motion) {
    Agent *agent = &agents->state[i];
    int64_t *count = &agents->counts[i];
    float *boxes = &agents->boxes[i * ROWS * world->columns];
    double ahead_m = motion[0] * world->dt_s, left_m = motion[1] * world->dt_s;
    agent->linear_mps = motion[0];
    agent->lateral_mps = motion[1];
    const double share = free_share(world, agent, *count, boxes, ahead_m, left_m);
    const bool met = share <= 1.0;
    if (met) {
        ahead_m *= share;
        left_m = 0.0;
    }
    agent->steps++;
    agent->distance_m += ahead_m;
    agent->contacts += met;
    const bool moved =
        set_place(world, agent, agent->x_m + ahead_m, agent->cell_y, agent->y_m + left_m);
    if (met)
        go_to_free_place(world, agent, count, boxes, moved);
    else if (moved)
        gather(world, agent, count, boxes);
    return met;
}

/* Seeing. */

static int64_t pick(const World *world, int64_t count, const float *restrict boxes, float x,
                    float y, float right_x, float right_y, float left_x, float left_y,
                    int32_t *restrict picked) {
    const int64_t columns = world->columns;
    const float range2 = (float)(world->range_m * world->range_m);
    uint8_t judged[MOST_NEAR];
    for (int64_t k = 0; k < count; k++) {
        const float dx = boxes[X * columns + k] - x, dy = boxes[Y * columns + k] - y;
        const float length = boxes[HALF_LENGTH * columns + k];
        const float width = boxes[HALF_WIDTH * columns + k];
        float away_x = fabsf(dx) - length, away_y = fabsf(dy) - width;
        away_x = away_x > 0.0f ? away_x : 0.0f;
        away_y = away_y > 0.0f ? away_y : 0.0f;
        const float from_right = right_x * dy - right_y * dx + length * fabsf(right_y) +
                                 width * fabsf(right_x);
        const float from_left = dx * left_y - dy * left_x + length * fabsf(left_y) +
                                width * fabsf(left_x);
        judged[k] = (away_x * away_x + away_y * away_y < range2) & (from_right >= 0.0f) &
                    (from_left >= 0.0f);
    }
    int64_t n = 0;
    for (int64_t k = 0; k < count; k++) {
        picked[n] = (int32_t)k;
        n += judged[k];
    }
    const int64_t filled = (n + 3) & ~3;
    for (int64_t k = n; k < filled; k++) picked[k] = (int32_t)columns - 1;
    return filled;
}

typedef struct {
    float x, y, half_length, half_width, paint;
} Box;

static inline Box seen(const float *boxes, int64_t columns, int32_t k, float x, float y) {
    return (Box){boxes[X * columns + k] - x, boxes[Y * columns + k] - y,
                 boxes[HALF_LENGTH * columns + k], boxes[HALF_WIDTH * columns + k],
                 boxes[PAINT * columns + k]};
}

static inline void meet(const Box *box, float per_ahead, float per_left, float *best, float *tint) {
    const float middle_x = box->x * per_ahead, reach_x = box->half_length * fabsf(per_ahead);
    const float middle_y = box->y * per_left, reach_y = box->half_width * fabsf(per_left);
    const float enters_x = middle_x - reach_x, leaves_x = middle_x + reach_x;
    const float enters_y = middle_y - reach_y, leaves_y = middle_y + reach_y;
    const float enters = enters_x > enters_y ? enters_x : enters_y;
    const float leaves = leaves_x < leaves_y ? leaves_x : leaves_y;
    const float length = enters > 0.0f ? enters : 0.0f;
    const bool nearer = (length <= leaves) & (length < *best);
    *best = nearer ? length : *best;
    *tint = nearer ? box->paint : *tint;
}

static inline void cast(const float *restrict boxes, int64_t columns,
                        const int32_t *restrict picked, int64_t end, float x, float y,
                        const float *restrict ahead, const float *restrict left,
                        float *restrict best, float *restrict tint) {
    float per_ahead[TILE], per_left[TILE];
    for (int r = 0; r < TILE; r++) {
        per_ahead[r] = 1.0f / copysignf(fmaxf(fabsf(ahead[r]), 1e-9f), ahead[r]);
        per_left[r] = 1.0f / copysignf(fmaxf(fabsf(left[r]), 1e-9f), left[r]);
    }
    for (int64_t n = 0; n < end; n += 4) {
        Box four[4];
        for (int f = 0; f < 4; f++) four[f] = seen(boxes, columns, picked[n + f], x, y);
        for (int r = 0; r < TILE; r++)
            for (int f = 0; f < 4; f++)
                meet(&four[f], per_ahead[r], per_left[r], &best[r], &tint[r]);
    }
}

static inline void shade(double range_m, const float *best, const float *tint,
                         uint8_t *restrict retina) {
    for (int r = 0; r < TILE; r++) {
        const int32_t bits = (int32_t)tint[r];
        const int32_t red = (bits >> 16) & 255, green = (bits >> 8) & 255, blue = bits & 255;
        const double tone = (299 * red + 587 * green + 114 * blue) / 255000.0;
        const double bright = best[r] < range_m ? tone * (1.0 - best[r] / range_m) : 0.0;
        retina[r] = (uint8_t)(int32_t)(255.0 * (tint[r] >= 0.0f ? bright : 0.0) + 0.5);
    }
}

static void sense(const World *world, const Agents *agents, int64_t i) {
    Agent *agent = &agents->state[i];
    const int64_t columns = world->columns;
    const float *restrict boxes = &agents->boxes[i * ROWS * columns];
    const float x = (float)agent->x_m, y = (float)agent->y_m;
    int32_t picked[MOST_NEAR];
    for (int64_t first = 0; first < world->rays; first += TILE) {
        const float *ahead = world->ahead + first, *left = world->left + first;
        float best[TILE], tint[TILE];
        for (int r = 0; r < TILE; r++) {
            best[r] = (float)world->range_m;
            tint[r] = -1.0f;
        }
        const int64_t end = pick(world, agents->counts[i], boxes, x, y, ahead[TILE - 1],
                                 left[TILE - 1], ahead[0], left[0], picked);
        cast(boxes, columns, picked, end, x, y, ahead, left, best, tint);
        shade(world->range_m, best, tint, &agents->stack[i * world->rays + first]);
    }
    agent->looks++;
}

/* Let all agents move, or look, or both. */
void advance(const World *world, const Agents *agents, const double *motions,
             const int64_t *actions, bool *met, int64_t n, bool moves, bool looks) {
    for (int64_t i = 0; i < n; i++) {
        if (moves) met[i] = step(world, agents, i, &motions[3 * actions[i]]);
        if (looks) sense(world, agents, i);
    }
}

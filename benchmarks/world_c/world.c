/* The reference world in plain C: the rival of the compiled world in world_against_c.py.
 *
 * The same algorithm on the same data: SplitMix64 keys, a near list of boxes in float32 relative
 * to the corner of the agent's cell, picked from a belt of boxes around the period, boxes judged by
 * range and wedge, rays cast at four boxes at a time, contact along the step, another free place after it. Only what the reference world needs:
 * one layer of upright white boxes, periodic edges, a point that goes ahead and sideways, one grey
 * eye with a multiple of 16 rays.
 *
 * cc -O3 -march=native -ffast-math -shared -fPIC
 */

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#define TILE 16
#define MOST_NEAR 1024
#define MOST_CHUNKS 256
#define CHUNK_BITS 24
#define TURN 4294967296.0
#define EIGHT 8
#define PLACE_DRAWS 64
#define PAST_BLOCKED_M 0.1
#define TOUCHING_M 1e-6
#define STEEPEST 1e-12

enum { X, Y, HALF_LENGTH, HALF_WIDTH, PAINT, ROWS };
enum { BELT_LENGTH, BELT_WIDTH, BELT_ROWS = 4 }; /* of sizes; the other two are for turned boxes */

typedef struct {
    double dt_s, width_m, side_m, chunk_m, ahead_m, behind_m, aside_m, reach_m;
    double width_low_m, width_high_m, length_low_m, length_high_m, range_m;
    int64_t across, stream, columns, belt_boxes, belt_columns, count_steps, rays;
    const double *counts;      /* (count_steps): probability of at most so many in a chunk */
    const float *ahead, *left; /* (rays): directions, a multiple of TILE of them */
    const float *per_ahead, *per_left; /* (rays): 1 over them */
} World;

typedef struct { /* AGENT_DTYPE of arrays/layout.py */
    int64_t world, cell_x, cell_y, steps, contacts;
    uint64_t seed, lane, draws;
    double x_m, y_m, heading_rad, distance_m, linear_mps, lateral_mps, angular_radps;
    int64_t looks, is_inside;
} Agent;

typedef struct {
    Agent *state;    /* (n) */
    int64_t *counts; /* (n): boxes in use */
    float *boxes;    /* (n, ROWS, columns) */
    int32_t *places; /* (n, 2, belt_boxes) */
    float *sizes;    /* (n, BELT_ROWS, belt_boxes) */
    int64_t *belts;  /* (n, belt_columns): boxes in each column of the belt */
    uint8_t *stack;  /* (n, rays) */
} Agents;

typedef struct { /* one agent's rows */
    Agent *agent;
    int64_t *count;
    float *boxes;
    int32_t *places;
    float *sizes;
    int64_t *belt;
} Own;

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

/* What is near: picked from a belt of all boxes of the columns of chunks in reach, over the whole
 * period. The belt loses and gains a column where the agent enters another one. In phases over flat
 * arrays, without branches, so that each becomes vector instructions. Places on the belt are 32-bit
 * integers that wrap. */

static inline double larger(double a, double b) { return a > b ? a : b; }

static inline int64_t around(int64_t j, int64_t across) {
    if (j >= 0 && j < across) return j; /* a division that is seldom needed */
    return ((j % across) + across) % across;
}

typedef struct { /* boxes of a column of chunks, with room for one EIGHT too many */
    uint64_t key[MOST_NEAR + EIGHT];
    double chunk[MOST_NEAR + EIGHT];
} Drawn;

static int64_t count_boxes(const World *world, uint64_t column, uint64_t *restrict keys,
                           int64_t *restrict boxes) {
    double draws[MOST_CHUNKS];
    for (int64_t j = 0; j < world->across; j++) {
        keys[j] = joined(column, (uint64_t)j);
        draws[j] = uniform(number(keys[j], 0));
        boxes[j] = 0;
    }
    for (int64_t k = 0; k < world->count_steps; k++) {
        const double passed = world->counts[k];
        int64_t more = 0;
        for (int64_t j = 0; j < world->across; j++) {
            boxes[j] += draws[j] >= passed;
            more += draws[j] >= passed;
        }
        if (!more) break;
    }
    int64_t all = 0;
    for (int64_t j = 0; j < world->across; j++) all += boxes[j];
    return all;
}

static void spread(const World *world, const uint64_t *restrict keys,
                   const int64_t *restrict boxes, Drawn *restrict drawn) {
    int64_t n = 0;
    for (int64_t j = 0; j < world->across && n + boxes[j] <= MOST_NEAR; j++) {
        for (int64_t k = 0; k < boxes[j]; k += EIGHT)
            for (int64_t e = 0; e < EIGHT; e++) {
                drawn->key[n + k + e] = keys[j] + (uint64_t)((k + e) * BLOCK + PLACE + 1) * GAMMA;
                drawn->chunk[n + k + e] = (double)j;
            }
        n += boxes[j];
    }
}

static void draw_boxes(const World *world, int64_t i, const Drawn *restrict drawn,
                       int32_t *restrict x, int32_t *restrict y, float *restrict half_length,
                       float *restrict half_width, int64_t count) {
    const double per_chunk = TURN / (double)world->across;
    const int64_t corner = i * (1 << CHUNK_BITS);
    for (int64_t k = 0; k < count; k++) {
        const uint64_t place = mixed(drawn->key[k]), size = mixed(drawn->key[k] + GAMMA);
        x[k] = (int32_t)(corner + (int64_t)(first_half(place) * (1 << CHUNK_BITS)));
        y[k] = (int32_t)(int64_t)((drawn->chunk[k] + second_half(place)) * per_chunk);
        half_width[k] =
            (float)(0.5 * between(world->width_low_m, world->width_high_m, first_half(size)));
        half_length[k] =
            (float)(0.5 * between(world->length_low_m, world->length_high_m, second_half(size)));
    }
}

static int64_t drop_first(const World *world, const Own *own, int64_t columns) {
    const int64_t gone = own->belt[0], boxes = world->belt_boxes;
    int64_t left = 0;
    for (int64_t k = 1; k < columns; k++) {
        left += own->belt[k];
        own->belt[k - 1] = own->belt[k];
    }
    for (int row = 0; row < 2; row++)
        for (int64_t k = 0; k < left; k++) {
            own->places[row * boxes + k] = own->places[row * boxes + gone + k];
            own->sizes[row * boxes + k] = own->sizes[row * boxes + gone + k];
        }
    return left;
}

static void move_belt(const World *world, const Own *own, int64_t steps) {
    const int64_t first = (int64_t)floor((-world->behind_m - world->reach_m) / world->chunk_m);
    const int64_t last =
        (int64_t)floor((world->chunk_m + world->ahead_m + world->reach_m) / world->chunk_m);
    const int64_t columns = last + 1 - first, boxes = world->belt_boxes;
    const uint64_t key = stream_key(world, own->agent->seed, OBSTACLES);
    int64_t kept = 0, end = 0, counts[MOST_CHUNKS];
    uint64_t keys[MOST_CHUNKS];
    Drawn drawn;
    if (steps == 1) {
        kept = columns - 1;
        end = drop_first(world, own, columns);
    }
    for (int64_t k = kept; k < columns; k++) {
        const int64_t i = own->agent->cell_x + first + k;
        int64_t count = count_boxes(world, joined(key, (uint64_t)i), keys, counts);
        spread(world, keys, counts, &drawn);
        if (count > boxes - end) count = boxes - end;
        draw_boxes(world, i, &drawn, own->places + end, own->places + boxes + end,
                   own->sizes + BELT_LENGTH * boxes + end, own->sizes + BELT_WIDTH * boxes + end,
                   count);
        own->belt[k] = count;
        end += count;
    }
}

static void pick_near(const World *world, const Own *own) {
    const int64_t boxes = world->belt_boxes, columns = world->columns;
    const int32_t *restrict places = own->places;
    const float *restrict sizes = own->sizes;
    const double length = world->chunk_m + world->ahead_m + world->behind_m;
    const float middle_x = (float)(0.5 * length - world->behind_m), half_x = (float)(0.5 * length);
    const float middle_y = (float)(0.5 * world->side_m);
    const float half_y = (float)(0.5 * world->side_m + world->aside_m);
    const float unit_x = (float)(world->chunk_m / (1 << CHUNK_BITS));
    const float unit_y = (float)(world->side_m * (double)world->across / TURN);
    const uint32_t corner_x = (uint32_t)(own->agent->cell_x * (1 << CHUNK_BITS));
    const uint32_t corner_y =
        (uint32_t)(int64_t)((double)own->agent->cell_y * (TURN / (double)world->across));
    float near_x[MOST_NEAR], near_y[MOST_NEAR];
    uint8_t is_near[MOST_NEAR];
    int32_t picked[MOST_NEAR];
    int64_t end = 0, n = 0;
    for (int64_t k = 0; k < world->belt_columns; k++) end += own->belt[k];
    for (int64_t k = 0; k < end; k++) {
        const float x = (float)(int32_t)((uint32_t)places[k] - corner_x) * unit_x;
        const float y = (float)(int32_t)((uint32_t)places[boxes + k] - corner_y) * unit_y;
        near_x[k] = x;
        near_y[k] = y;
        is_near[k] = (fabsf(x - middle_x) <= half_x + sizes[BELT_LENGTH * boxes + k]) &
                     (fabsf(y - middle_y) <= half_y + sizes[BELT_WIDTH * boxes + k]);
    }
    for (int64_t k = 0; k < end; k++) {
        picked[n] = (int32_t)k;
        n += is_near[k];
    }
    n = n < columns ? n : columns;
    float *restrict near = own->boxes;
    for (int64_t k = 0; k < n; k++) {
        const int32_t at = picked[k];
        near[X * columns + k] = near_x[at];
        near[Y * columns + k] = near_y[at];
        near[HALF_LENGTH * columns + k] = sizes[BELT_LENGTH * boxes + at];
        near[HALF_WIDTH * columns + k] = sizes[BELT_WIDTH * boxes + at];
        near[PAINT * columns + k] = 0xFFFFFF;
    }
    *own->count = n;
}

/* Where an agent stands. */

static inline void set_place(const World *world, const Own *own, double x_m, int64_t cell_y,
                             double y_m, bool anew) {
    Agent *agent = own->agent;
    const int64_t before_x = agent->cell_x, before_y = agent->cell_y;
    const double steps_x = floor(x_m / world->chunk_m), steps_y = floor(y_m / world->side_m);
    agent->cell_x += (int64_t)steps_x;
    agent->x_m = x_m - steps_x * world->chunk_m;
    agent->cell_y = around(cell_y + (int64_t)steps_y, world->across);
    agent->y_m = y_m - steps_y * world->side_m;
    if (anew || agent->cell_x != before_x)
        move_belt(world, own, anew ? 0 : agent->cell_x - before_x);
    if (anew || agent->cell_x != before_x || agent->cell_y != before_y) pick_near(world, own);
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

static void go_to_free_place(const World *world, const Own *own, double x_m) {
    for (;;) {
        for (int tried = 0; tried < PLACE_DRAWS; tried++) {
            const double y_m = world->width_m * uniform(draw(world, own->agent));
            set_place(world, own, x_m, 0, y_m, false);
            x_m = own->agent->x_m;
            if (!touches(world, own->agent, *own->count, own->boxes)) return;
        }
        x_m += PAST_BLOCKED_M;
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
    uint8_t judged[MOST_NEAR];
    for (int64_t k = 0; k < count; k++) {
        judged[k] = (fabsf(boxes[X * columns + k] - x) <= boxes[HALF_LENGTH * columns + k] + rx) &
                    (fabsf(boxes[Y * columns + k] - y) <= boxes[HALF_WIDTH * columns + k] + ry);
        touched |= judged[k];
    }
    if (!touched) return 1e300;
    const double length = sqrt(way_x * way_x + way_y * way_y);
    const double ahead = way_x / length, left = way_y / length;
    const double per_ahead = 1.0 / copysign(larger(fabs(ahead), STEEPEST), ahead);
    const double per_left = 1.0 / copysign(larger(fabs(left), STEEPEST), left);
    double first = 1e300;
    for (int64_t k = 0; k < count; k++) {
        if (!judged[k]) continue;
        const double met = meets_box(boxes[X * columns + k] - agent->x_m,
                                     boxes[Y * columns + k] - agent->y_m,
                                     boxes[HALF_LENGTH * columns + k],
                                     boxes[HALF_WIDTH * columns + k], per_ahead, per_left);
        first = met < first ? met : first;
    }
    return first > length ? 1e300 : first / length;
}

static bool step(const World *world, const Own *own, const double *motion) {
    Agent *agent = own->agent;
    double ahead_m = motion[0] * world->dt_s, left_m = motion[1] * world->dt_s;
    agent->linear_mps = motion[0];
    agent->lateral_mps = motion[1];
    const double share = free_share(world, agent, *own->count, own->boxes, ahead_m, left_m);
    const bool met = share <= 1.0;
    if (met) ahead_m *= share;
    agent->steps++;
    agent->distance_m += ahead_m;
    agent->contacts += met;
    if (met)
        go_to_free_place(world, own, agent->x_m + ahead_m);
    else
        set_place(world, own, agent->x_m + ahead_m, agent->cell_y, agent->y_m + left_m, false);
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
    for (int64_t k = n; k < filled; k++) picked[k] = picked[0];
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
                        const float *restrict per_ahead, const float *restrict per_left,
                        float *restrict best, float *restrict tint) {
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

static void sense(const World *world, const Own *own, uint8_t *restrict stack) {
    const float x = (float)own->agent->x_m, y = (float)own->agent->y_m;
    const float *restrict boxes = own->boxes;
    int32_t picked[MOST_NEAR];
    for (int64_t first = 0; first < world->rays; first += TILE) {
        const float *ahead = world->ahead + first, *left = world->left + first;
        float best[TILE], tint[TILE];
        for (int r = 0; r < TILE; r++) {
            best[r] = (float)world->range_m;
            tint[r] = -1.0f;
        }
        const int64_t end = pick(world, *own->count, boxes, x, y, ahead[TILE - 1], left[TILE - 1],
                                 ahead[0], left[0], picked);
        cast(boxes, world->columns, picked, end, x, y, world->per_ahead + first,
             world->per_left + first, best, tint);
        shade(world->range_m, best, tint, stack + first);
    }
    own->agent->looks++;
}

/* Let all agents move, or look, or both. */
void advance(const World *world, const Agents *agents, const double *motions,
             const int64_t *actions, bool *met, int64_t n, bool moves, bool looks) {
    for (int64_t i = 0; i < n; i++) {
        const Own own = {agents->state + i,
                         agents->counts + i,
                         agents->boxes + i * ROWS * world->columns,
                         agents->places + i * 2 * world->belt_boxes,
                         agents->sizes + i * BELT_ROWS * world->belt_boxes,
                         agents->belts + i * world->belt_columns};
        if (moves) met[i] = step(world, &own, &motions[3 * actions[i]]);
        if (looks) sense(world, &own, agents->stack + i * world->rays);
    }
}

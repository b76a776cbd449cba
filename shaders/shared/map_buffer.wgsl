// A light map in a buffer: MAP_WORDS words a texel, texel after texel, u fastest.
// Cost: one buffer read a word.
#import map::{map, Tap}
#import column::Column

#ifdef MAP_WORDS
const WORDS: u32 = #{MAP_WORDS}u;
#else
const WORDS: u32 = 1u;
#endif

@group(2) @binding(9) var<storage, read> map_word_buffer: array<u32>;
@group(2) @binding(10) var<storage, read_write> map_word_buffer_store: array<u32>;

fn first_word(texel: vec2u) -> u32 {
    return (texel.y * map.resolution + texel.x) * WORDS;
}

fn store_word(column: Column, i: u32, word: u32) {
    map_word_buffer_store[first_word(column.texel) + i] = word;
}

fn fetch_word(tap: Tap, i: u32) -> u32 {
    return map_word_buffer[first_word(vec2u(tap.texel)) + i];
}

#pragma once

#include "fricid/film/canvas.hpp"
#include "fricid/film/run_film.hpp"

namespace fricid::film {

/// @param arm  picture for the right half
Image draw_opening_card(const RunFilm& film, const Image& arm);
Image draw_closing_card(const RunFilm& film);

}  // namespace fricid::film

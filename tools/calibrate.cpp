// A camera's file from images of a board, and whether a camera still is as its file says.
#include <CLI/CLI.hpp>
#include <opencv2/core/utils/logger.hpp>

#include "runtime/command_line.hpp"
#include "tools/calibrate_run.hpp"

using namespace stevedore;

namespace {

void declare(CLI::App& app, CalibrateOptions& o) {
  app.add_option("IMAGES", o.images, "Images of the board: files, folders or patterns");
  app.add_option("--video", o.video, "Instead: a video file")->type_name("FILE");
  app.add_option(
         "--camera", o.camera,
         "Instead: a V4L2 device or a GStreamer pipeline; ends when nothing is missing, or with Ctrl-C")
      ->type_name("DEV");
  app.add_option("--board", o.kind, "chessboard, or charuco, which may be partly out of the picture")
      ->check(CLI::IsMember({"chessboard", "charuco"}));
  app.add_option("--corners", o.corners, "Inner corners of the board: a square less than there are, each way")
      ->type_name("COLSxROWS");
  const CLI::Range length(1e-4, 10.0);
  app.add_option("--square", o.board.square_m, "Side of a square, in metres")->check(length);
  app.add_option("--marker", o.board.marker_m, "Of charuco: side of a marker, in metres")->check(length);
  app.add_option("--codes", o.board.codes, "Of charuco: the markers")->check(CLI::IsMember(code_names()));
  app.add_option("--lens", o.lens,
                 "How the lens bends the image; equidistant for more than 100 degrees or so")
      ->check(CLI::IsMember({"plumb_bob", "equidistant"}));
  app.add_option("--out", o.out, "Camera file to write; beside it a picture of coverage and residuals, .png")
      ->type_name("FILE");
  app.add_option("--check", o.check, "Write nothing, hold this camera file against the images")
      ->type_name("FILE");
  app.add_option("--print", o.print, "Only write the board as an image for the printer")->type_name("FILE");
  app.footer(
      "Says of each image whether it is taken or why not, and which views are still missing.\n\n"
      "  calibrate --print board.png --board charuco\n"
      "  calibrate --board charuco --camera /dev/video0 --out config/cameras/mine.yaml\n"
      "  calibrate --board charuco --check config/cameras/mine.yaml new/*.png");
}

}  // namespace

int main(int argc, char** argv) {
  return guarded_main([&] {
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);  // what fails is said in words
    CLI::App app("Makes a camera's file from images of a board, or checks one.", "calibrate");
    app.option_defaults()->always_capture_default();
    CalibrateOptions options;
    declare(app, options);
    parse_command_line(
        app, argc, argv,
        "1 if no file could be made, or the one checked does not fit or these views can't tell");
    return calibrate(options);
  });
}

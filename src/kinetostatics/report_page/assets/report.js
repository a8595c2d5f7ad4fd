"use strict";
/* A picture of the scene for printing, since not all browsers print the content of a frame. */
(() => {
  const frame = document.querySelector(".scene iframe"), still = document.querySelector(".still");
  const take = () => {
    const scene = frame.contentWindow && frame.contentWindow.robot_page;
    if (scene && scene.ready) still.src = scene.picture();
  };
  addEventListener("message", take); // sent by the scene when it is drawn
  addEventListener("beforeprint", take);
  take();
})();

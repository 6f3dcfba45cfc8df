# Debian 12 with img_recog, for systems that cannot run it themselves; README.md has the commands.
FROM debian:bookworm

# tini ends what a node leaves, and passes Ctrl-C on
RUN apt-get update -q && apt-get install -y -q --no-install-recommends tini \
    && rm -rf /var/lib/apt/lists/* && useradd --create-home --shell /bin/bash ros
WORKDIR /home/ros/img_recog
# what setup needs: it runs again only if one of these has changed
COPY run packages-debian.txt ./
COPY requirements requirements
COPY tools tools
# the system packages need root; all that is written here is the user's
RUN ./run -y setup && apt-get clean && rm -rf /var/lib/apt/lists/* build/*.log \
    && chown -R ros:ros /home/ros
COPY --chown=ros:ros . .
USER ros
# Docker on Windows makes all files executable, and rosrun then finds each program twice
RUN find scripts src templates -type f -exec chmod a-x {} + && ./run build

ENTRYPOINT ["tini", "--", "/home/ros/img_recog/tools/container.bash"]

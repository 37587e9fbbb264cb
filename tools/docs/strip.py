#!/usr/bin/python3
"""strip.py OUT.jpg WIDTH IMAGE=LABEL...: pictures of one size side by side with labels, each WIDTH pixels wide. Needs python3-pil."""
import sys

from PIL import Image, ImageDraw, ImageFont

GAP, LABEL = 8, 24
PAPER, INK = (246, 246, 246), (48, 48, 48)

output, width, *given = sys.argv[1:]
width = int(width)
pictures = []
for word in given:
    file, label = word.rsplit("=", 1)
    image = Image.open(file).convert("RGB")
    pictures.append((image.resize((width, round(image.height * width / image.width)), Image.LANCZOS), label))
height = max(image.height for image, _ in pictures)
strip = Image.new("RGB", (len(pictures) * (width + GAP) - GAP, height + LABEL), PAPER)
draw, font = ImageDraw.Draw(strip), ImageFont.load_default()
for i, (image, label) in enumerate(pictures):
    left = i * (width + GAP)
    strip.paste(image, (left, 0))
    box = draw.textbbox((0, 0), label, font=font)
    draw.text((left + (width - box[2]) // 2, height + (LABEL - box[3]) // 2), label, fill=INK, font=font)
strip.save(output, quality=88)
